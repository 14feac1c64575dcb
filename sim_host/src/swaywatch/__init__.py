"""Swaywatch: how far a car-trailer combination is from yaw instability, and why.

Axes are ISO 8855 (x forward, y left, z up), units are SI everywhere inside the package.
The estimator itself is the C core in ``lib/``, which :mod:`swaywatch.ecu.core` runs.
"""

__version__ = "0.1.0"
