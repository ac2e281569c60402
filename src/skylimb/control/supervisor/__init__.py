"""What stands between every controller and every vehicle, and keeps people safe.

    measurement -> gates -> prediction -> table -> controller -> limits -> command

`table.toml` says what is done when; `supervisor.py` does it. Start with those two.
"""
