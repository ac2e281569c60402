"""Laws of the shape slot: one file each, named by a preset's `[shape] law = "..."`."""
