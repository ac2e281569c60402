"""Laws of the attitude slot: one file each, named by a preset's `[attitude] law = "..."`."""
