"""The middleware of ROS 1: the only place where rospy is imported, and nothing but moving messages.

subscribers -> inbox -> plain messages -> a profile's tick (`apps.ros`) -> plain messages -> publishers
"""
