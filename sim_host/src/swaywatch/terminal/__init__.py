"""The terminal: what a command says, how far it is, how it ends."""
