"""Postures, vectoring angles and reference trajectories."""
