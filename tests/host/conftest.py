"""What the host tests share: where recordings are found, and a clock."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

DATA = Path(__file__).resolve().parent.parent / "data"


def built_fmu(name: str) -> Path:
    """One of our FMUs, built."""
    root = DATA.parents[1]
    path = root / "build" / "fmu" / f"{name}.fmu"
    subprocess.run(["make", "-s", "-C", str(root), str(path.relative_to(root))], check=True)
    return path


class Clock:
    """Time that passes only while somebody sleeps or sends."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += max(seconds, 1e-5)


def recordings(*parts: str) -> Path:
    """Path inside the folder of shared recordings; skips the test where there is none.

    The folder is ``$SWAYWATCH_RECORDINGS``, or ``shared/recordings`` beside any parent of the
    checkout.
    """
    candidates = [parent / "shared" / "recordings" for parent in Path(__file__).resolve().parents]
    if "SWAYWATCH_RECORDINGS" in os.environ:
        candidates.insert(0, Path(os.environ["SWAYWATCH_RECORDINGS"]))
    for folder in candidates:
        if folder.joinpath(*parts).exists():
            return folder.joinpath(*parts)
    pytest.skip(f"no shared recordings with {'/'.join(parts)}; set SWAYWATCH_RECORDINGS")
