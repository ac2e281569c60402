"""The middleware of ROS 2: DDS by `cyclonedds`, and nothing but moving messages; no ROS need be installed.

readers -> inbox -> plain messages -> a profile's tick (`apps.ros`) -> plain messages -> writers
"""
