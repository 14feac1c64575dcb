"""The report: what an engineer puts on the table."""
