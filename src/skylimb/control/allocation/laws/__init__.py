"""Laws of the allocation slot: one file each, named by a preset's `[allocation] law = "..."`."""
