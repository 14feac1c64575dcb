"""Library of missing physics and faults: one file for each word of the list."""
