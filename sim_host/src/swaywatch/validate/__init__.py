"""Validation of a simulation against a recording: chapter 5 of the dissertation as one command.

Recording and simulation go through the same C core; every parameter and state has to agree within
5 % (5.2.4). Data flows twin (our simulator) or fmu_twin (the user's FMU) -> compare -> correct ->
loop -> page.
"""
