"""Oblique long-range geolocation: from a pixel to a ground point, the calibration of the way, its uncertainty.

chain: pixel, gimbal, boresight, lever arm.  ground: height surface or elevation model, through the air.
It reads poses, pictures and elevation models; it knows nothing of how they came about.
"""
