"""Sweeps: many runs of one scenario, some values varied, the same seeds for all; resumable."""
