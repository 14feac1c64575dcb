"""The plant: one compiled vehicle on springs, with a slot for every physics that can be missing."""
