"""The lab's robot at user level: its flight states, its topics, and the node that speaks them.

    messages (plain) -> senses -> pilot: flight states, targets, guard -> command -> messages (plain)

All but `ros1.rim` knows no ROS and is tested without it. Only `ros1.rim` imports rospy.
"""
