"""Types of the plant's binding (built by plant_build.py)."""

from typing import Any

ffi: Any
lib: Any
