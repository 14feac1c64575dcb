"""Which explanations a recording supports, and how surely."""
