"""What the paper prints: its configuration, numbers and claims, to stand beside those of a run."""
