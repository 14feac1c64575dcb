"""Which recordings of a folder are surveyed, and with which vehicle.toml and signals.toml."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from swaywatch import __version__
from swaywatch.errors import RecordingError
from swaywatch.recording import SUFFIXES


@dataclass(frozen=True)
class SurveyRun:
    """One recording, and what it is read with; None: nothing was found for it.

    Attributes
    ----------
    name : path below the surveyed folder, with ``/``
    """

    name: str
    recording: Path
    vehicle: Path | None
    signals: Path | None

    @property
    def place(self) -> str:
        """Folder of its results: the name, its suffix with an underscore (run1.blf, run1.mf4)."""
        stem, _, suffix = self.name.rpartition(".")
        return f"{stem}_{suffix}"

    def key(self) -> str:
        """Changes whenever a file or the version does; results of the same key are kept."""
        digest = hashlib.sha256(__version__.encode())
        for path in (self.recording, self.vehicle, self.signals):
            if path is not None:
                with path.open("rb") as stream:
                    digest.update(hashlib.file_digest(stream, "sha256").digest())
        return digest.hexdigest()


def find_runs(
    folder: Path, vehicle: Path | None, signals: Path | None, exclude: Sequence[str], out: Path
) -> list[SurveyRun]:
    """Recordings below a folder, in the order of their names.

    A ``vehicle.toml`` and a ``signals.toml`` beside a recording, or in the nearest folder above it
    up to `folder`, are taken before those given.

    Raises
    ------
    RecordingError
        No such folder, or no recording in it.
    """
    if folder.is_file():
        raise RecordingError(
            f"{folder}: this is a file; survey takes a folder, such as {folder.parent}"
            " (analyze and diagnose take single recordings)"
        )
    if not folder.is_dir():
        raise RecordingError(f"{folder}: no such folder (expected one with recordings in it)")
    runs = []
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() not in SUFFIXES or path.is_dir() or out in path.parents:
            continue  # what is no file either, or cannot be read, is said in its place
        if any(fnmatch(path.name, pattern) for pattern in exclude):
            continue
        runs.append(
            SurveyRun(
                path.relative_to(folder).as_posix(),
                path,
                _nearest(path, folder, "vehicle.toml") or vehicle,
                _nearest(path, folder, "signals.toml") or signals,
            )
        )
    if not runs:
        raise RecordingError(
            f"{folder}: no recording in it; expected files ending in {', '.join(SUFFIXES)}"
        )
    return runs


def _nearest(path: Path, top: Path, name: str) -> Path | None:
    for parent in path.parents:
        if (parent / name).is_file():
            return parent / name
        if parent == top:
            break
    return None


def groups(runs: Sequence[SurveyRun]) -> dict[tuple[Path, Path], list[SurveyRun]]:
    """Runs of the same combination: the same vehicle.toml and the same signals.toml."""
    found: dict[tuple[Path, Path], list[SurveyRun]] = {}
    for run in runs:
        if run.vehicle is not None and run.signals is not None:
            found.setdefault((run.vehicle, run.signals), []).append(run)
    return found
