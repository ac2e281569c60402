"""Laws of the estimation slot: one file each, named by a preset's `[estimation] law = "..."`."""
