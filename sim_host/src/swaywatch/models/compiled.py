"""Typed door to numba, with a cache that notices a change in any file the kernel is built from.

Numba's on-disk cache looks at the file of the cached function only. The kernel of the double track
calls small functions of :mod:`swaywatch.models.physics`; a change there must invalidate it too, so
the cache folder is named after a digest of all these sources.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

_HERE = Path(__file__).parent
_SOURCES = ("compiled.py", "layout.py", "double_track_kernel.py")


def _cache_folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in [*(_HERE / name for name in _SOURCES), *sorted(_HERE.glob("physics/*.py"))]:
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(base) / "swaywatch" / digest.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"swaywatch-{digest.hexdigest()[:16]}"
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def inlined(function: F) -> F:
    """Compile a small function that a kernel calls."""
    return cast(F, numba.njit(error_model="numpy")(function))


def kernel(function: F) -> F:
    """Compile a kernel once per machine and source state."""
    settings: Any = numba.config
    before = settings.CACHE_DIR
    settings.CACHE_DIR = str(_cache_folder())
    try:
        return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
    finally:
        settings.CACHE_DIR = before
