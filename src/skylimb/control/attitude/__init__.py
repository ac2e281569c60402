"""Attitude laws and the target they follow."""
