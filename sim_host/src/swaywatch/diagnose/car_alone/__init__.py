"""The same diagnosis for a car without a trailer."""
