"""Vehicle models of rising depth behind one interface.

:mod:`~swaywatch.models.single_track`: linear, four states, the reference;
:mod:`~swaywatch.models.double_track`: eight wheels, exact kinematics, switchable physics.
"""
