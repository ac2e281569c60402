"""From experiment and controller to a run: a take-off is prepared, a loop flies it, its record is scored."""
