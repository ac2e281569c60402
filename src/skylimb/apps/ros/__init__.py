"""The lab's robot at user level: its flight states, its topics, and the node that speaks them.

    messages (plain) -> sensors -> pilot: flight states, targets, guard -> command -> messages (plain)

Topics, types and conversions stand in `skylimb.analysis.exchange.lab_topics` and `codec`. Nothing here
imports a middleware: `apps.ros1` and `apps.ros2` are rims, in a process of their own behind `bridge.py`.
Start reading at `run.py`, which builds a node, then `pilot.py`, `states.py` and `transitions.py`.
"""
