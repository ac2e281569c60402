"""Searches gains over a campaign's draws, and judges what it found on draws that it has not seen.

The search is CMA-ES (the `cma` package), which needs no gradient, bears noise and compares trials by their
order alone. Every controller gets the same number of trials over the same draws, its own gains being the
first of them.
"""
