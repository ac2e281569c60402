"""Experiments as data, and the public calls that fly them."""
