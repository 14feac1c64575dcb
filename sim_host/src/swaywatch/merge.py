"""Measured and estimated channels of a drive on one clock, for the viewers people have."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from swaywatch.analysis import DriveResult
from swaywatch.ecu.core import unit_of
from swaywatch.recording import Series, write_recording
from swaywatch.recording.layouts import write_layouts

PREFIX = "swaywatch."
"""Of the names of estimates, so that they stand together in a viewer's list."""


def merged(result: DriveResult) -> dict[str, Series]:
    """Measured roles (SI, ISO 8855) and every column of the estimates, by name.

    Times are those of the recording; an estimate stands at the middle of its window.
    """
    drive, estimates = result.drive, result.estimates
    found = {}
    for name, channel in drive.channels.items():
        time_ns = drive.start_ns + np.rint(channel.time_s * 1e9).astype(np.int64)
        comment = f"measured, {channel.signal}; roles and axes as in ISO 8855"
        found[name] = Series(time_ns, channel.value, channel.unit, comment)
    if not len(estimates):
        return found
    time_ns = drive.start_ns + np.rint(estimates.time_s * 1e9).astype(np.int64)
    keep = np.concatenate([[True], np.diff(time_ns) > 0])
    for column, value in estimates.columns.items():
        comment = "estimated by swaywatch's core, at the middle of its window"
        found[PREFIX + column] = Series(time_ns[keep], value[keep], unit_of(column), comment)
    return found


def write_merged(path: Path, names: list[str], results: list[DriveResult]) -> list[Path]:
    """Write one file for each drive: `path`, or with several drives ``path_NAME``.

    Beside an MCAP file stand layouts for its viewers (:mod:`swaywatch.recording.layouts`).

    Parameters
    ----------
    path
        ``.mf4``, ``.mcap``, ``.mat``, ``.parquet`` or ``.csv``.
    names
        Of the drives, each once.
    """
    written = []
    for name, result in zip(names, results, strict=True):
        target = path if len(results) == 1 else path.with_stem(f"{path.stem}_{name}")
        signals = merged(result)
        write_recording(target, signals)
        written.append(target)
        if target.suffix.lower() == ".mcap":
            written += write_layouts(target, signals)
    return written
