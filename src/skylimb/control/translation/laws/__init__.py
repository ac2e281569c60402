"""Laws of the translation slot: one file each, named by a preset's `[translation] law = "..."`."""
