"""Scores: each declared at the function that computes it; the verdict judges those with a tolerance."""
