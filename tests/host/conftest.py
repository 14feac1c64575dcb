"""What the host tests share: where recordings are found, and a clock."""

from __future__ import annotations

import fcntl
import os
import subprocess
from pathlib import Path

import pytest

from swaywatch.cli import main

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


@pytest.fixture(scope="session")
def diagnosed_p03(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder that ``swaywatch diagnose`` wrote of practice case p03, once for all processes."""
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    case, out = DATA / "practice" / "p03", shared / "diagnosed_p03"
    with (shared / "diagnosed_p03.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (out / "report.html").exists():
            roles = [
                "--vehicle",
                str(case / "vehicle.toml"),
                "--signals",
                str(case / "signals.toml"),
            ]
            runs = [str(case / "run1.asc"), str(case / "run2.asc")]
            assert main(["diagnose", *runs, *roles, "--out", str(out)]) == 0
    return out


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
