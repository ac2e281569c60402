"""Translation laws: one file each, picked by a preset's `[translation] law = "..."`."""
