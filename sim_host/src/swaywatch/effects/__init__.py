"""Effects: what physics may be missing or wrong in a measurement, one file an effect."""
