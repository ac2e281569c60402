"""Laws of the contact slot: one file each, named by a preset's `[contact] law = "..."`."""
