"""What a user starts: the command line, the studio, the lab's node on ROS 1, the import of robots.

What it may import: every wing; nothing imports it but `skylimb` itself. An app says things to a person and
takes their commands; what it does is one call of a public function of the wings below. None plans, checks or
scores a flight by itself.

Where to start reading: `cli.main` and `cli.commands` (a verb is a class and one call), `studio.session` (live
flights), `ros.node` and `ros.tick` (one tick of plain messages), `catalogue.entries` (all that can be set
or scored), `robot_import.checking` (a file from elsewhere held against what can fly).
"""
