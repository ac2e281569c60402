"""Robot descriptions from elsewhere: read, recognised, checked, drawn, and written as a robot of skylimb's.

A URDF or xacro file becomes a tree of XML (`urdf_text`, `tree`). `roles` says what each moving joint is for,
by the names that the laboratory uses, by the tree's structure, or by a mapping file of the user's. `proposal`
makes the flight TOML of it, each number with its origin. `checking` holds the result against what can exist
and fly.
"""
