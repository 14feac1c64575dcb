"""Chapters 3, 5 and 6 of the reference again: our simulator makes the data, the C core reads it.

Reference: N. Zhang, *Stability Investigation of Car-trailer Combinations based on Time-Frequency
Analysis*, TU Darmstadt 2015. Every number that is identified comes out of the C core.
"""

from __future__ import annotations
