"""Logs in everyone's tools: NetCDF, ROS 1 bags and MCAP, with the lab's topics, types, frames and units.

    Run <-> stream of messages <-> container (bag, MCAP)

A container that skylimb wrote gives back the whole run to the bit, and has the lab's topics beside it. One
that somebody else wrote gives what its topics hold. No ROS is needed: the extra `logs` brings pure Python.
"""
