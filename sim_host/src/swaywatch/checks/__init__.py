"""Is a recording what it says it is? Checks that need no model of the tyres."""
