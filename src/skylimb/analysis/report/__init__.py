"""What a run leaves for a reader: its folder, the report, videos, and what a replay makes of its log."""
