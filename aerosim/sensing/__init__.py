"""Devices: how the rows, the mount, the camera and the navigation see the truth, and how they err."""
