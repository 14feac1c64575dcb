"""Frequency and damping of free oscillations in any recording, without a vehicle model."""
