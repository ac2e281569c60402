"""The lab's robot at user level: its flight states, its topics, and the node that speaks them.

    messages (plain) -> sensors -> pilot: flight states, targets, guard -> command -> messages (plain)

Topics, types and conversions stand in `skylimb.analysis.exchange.lab_topics` and `codec`. All but
`ros1.bridge` knows no ROS and is tested without it. Only `ros1.bridge` imports rospy. Start reading at
`run.py`, which builds a node, then `pilot.py` and `states.py`.
"""
