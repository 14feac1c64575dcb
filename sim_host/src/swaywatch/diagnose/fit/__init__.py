"""Fit of a combination with effects to all channels of all runs."""
