"""A verdict in words, numbers and as a page."""
