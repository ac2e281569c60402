"""A controller on the wall clock: absolute deadlines, watchdogs, a retreat, and vehicles over a network.

    Pacer (when) -> Watchdog (what is believed) -> GuardedController (what is commanded) -> Timing

Nothing here knows a simulator or a middleware. A simulated plant, a robot behind ROS and one behind a socket
fly with the same guard.
"""
