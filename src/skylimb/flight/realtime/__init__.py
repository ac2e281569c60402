"""A controller on the wall clock: absolute deadlines, the supervisor around it, and vehicles over a network.

    Pacer (when) -> GuardedController (what is believed and commanded) -> Timing

Nothing here knows a simulator or a middleware. A simulated plant, a robot behind ROS and one behind a socket
fly with the same guard.
"""
