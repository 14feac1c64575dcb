"""The ECU's software in Python: the C core and the node through cffi, and the bus they are on."""
