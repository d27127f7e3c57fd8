"""Trajectories that were recorded elsewhere, flown again."""
