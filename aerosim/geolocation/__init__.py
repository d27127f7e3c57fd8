"""Oblique long-range geolocation: from a pixel to a ground point, the calibration of the way, its uncertainty.

chain: pixel, gimbal, boresight, lever arm, and back.  ground: rays to a height or an elevation model, through
the air. calibration: corrections from control points, and which of them the data can say.  uncertainty: CE90,
LE90, ellipses. It reads poses, pictures and elevation models; it knows nothing of how they came about.
"""
