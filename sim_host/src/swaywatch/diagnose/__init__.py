"""Diagnosis: where a simulation and a recording differ, and what physics was left out."""
