"""Co-simulation: a user's FMU (FMI 2 or 3) as the simulation of a recorded drive and as a plant.

mapping.py says which variable plays which role, fmu.py opens and steps it, plant.py is the plant of
`swaywatch hil`; `validate/fmu_twin.py` drives it with what was recorded. FMPy does the calls.
"""

from __future__ import annotations

from pathlib import Path


def is_fmu(path: Path) -> bool:
    """Whether a file is an FMU, by its name."""
    return path.suffix.lower() == ".fmu"
