"""Many drives of one scenario, on all cores: each with its own seed and varied values.

::

    [[vary]]
    key = "speed_kmh"               # dots lead into tables and arrays: "manoeuvre.0.angle_deg"
    low = 90.0
    high = 125.0
"""

from __future__ import annotations

import copy
import csv
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import ScenarioError
from swaywatch.simulate.run import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.simulate.table import Table
from swaywatch.toml_file import load_toml

MOST = 100_000


@dataclass(frozen=True)
class DriveJob:
    """One drive: the scenario's content with its values, and where it goes."""

    number: int
    content: dict[str, Any] = field(repr=False)
    folder: Path
    place: str
    seed: int
    values: tuple[tuple[str, float], ...]
    out: Path | None


@dataclass(frozen=True)
class DriveOutcome:
    """What became of a drive."""

    number: int
    seed: int
    values: tuple[tuple[str, float], ...]
    duration_s: float
    whole: bool
    largest_yaw_rate_rad_s: float
    largest_articulation_rad: float
    file: str


def jobs_of(
    scenario: Path, count: int, out: Path | None = None, suffix: str = ".blf", seed: int = 1
) -> list[DriveJob]:
    """The drives of a campaign; the same seed gives the same drives.

    Raises
    ------
    ScenarioError
        The scenario, a ``[[vary]]`` or the count is wrong.
    """
    if not 1 <= count <= MOST:
        raise ScenarioError(f"{count} drives: expected 1 to {MOST}")
    content = load_toml(scenario, ScenarioError, "scenario")
    ranges = list(_ranges(Table({"vary": content.pop("vary", [])}, str(scenario)), content))
    random = np.random.default_rng(seed)
    jobs = []
    for number in range(count):
        mine = copy.deepcopy(content)
        values = []
        for key, low, high in ranges:
            value = float(random.uniform(low, high))
            _put(mine, key, value)
            values.append((key, value))
        file = None if out is None else out / f"drive_{number + 1:05d}{suffix}"
        jobs.append(
            DriveJob(
                number + 1, mine, scenario.parent, str(scenario), seed + number, tuple(values), file
            )
        )
    return jobs


def run_campaign(
    jobs: Sequence[DriveJob],
    workers: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> list[DriveOutcome]:
    """Simulate all drives, on all cores by default; outcomes in order."""
    count = min(workers or os.cpu_count() or 1, len(jobs))
    outcomes = [run_job(jobs[0])]  # meets bad input before any process starts
    progress(1)
    rest = jobs[1:]
    if count <= 1 or len(rest) < 2:
        for job in rest:
            outcomes.append(run_job(job))
            progress(len(outcomes))
        return outcomes
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        chunk = max(1, min(16, len(rest) // (4 * count)))
        for outcome in pool.map(run_job, rest, chunksize=chunk):
            outcomes.append(outcome)
            progress(len(outcomes))
    return outcomes


def run_job(job: DriveJob) -> DriveOutcome:
    """Simulate one drive and write it, if it has a file."""
    scenario = read_scenario(
        job.content, f"drive_{job.number:05d}", job.folder, job.place, job.seed
    )
    drive, trace = simulate_scenario(scenario)
    if job.out is not None:
        from swaywatch.ecu.bus import encode_drive
        from swaywatch.recording import write_recording

        write_recording(job.out, encode_drive(drive))
    return DriveOutcome(
        job.number,
        job.seed,
        job.values,
        drive.duration_s,
        trace.whole,
        float(np.nanmax(np.abs(trace["car_yaw_rate"]))),
        float(np.nanmax(np.abs(trace["articulation"]))) if "articulation" in trace else 0.0,
        job.out.name if job.out is not None else "",
    )


def write_table(path: Path, outcomes: Sequence[DriveOutcome]) -> None:
    """One line per drive: seed, varied values, what became of it (CSV)."""
    keys = [key for key, _ in outcomes[0].values]
    head = ["drive", "seed", *keys, "duration_s", "whole", "largest_car_yaw_rate_rad_s",
            "largest_articulation_rad", "file"]  # fmt: skip
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(head)
        for o in outcomes:
            writer.writerow([
                o.number, o.seed, *(f"{value:.9g}" for _, value in o.values),
                f"{o.duration_s:.3f}", int(o.whole), f"{o.largest_yaw_rate_rad_s:.6g}",
                f"{o.largest_articulation_rad:.6g}", o.file,
            ])  # fmt: skip


def _ranges(table: Table, content: dict[str, Any]) -> Iterator[tuple[str, float, float]]:
    for entry in table.tables("vary"):
        key = entry.raw("key")
        if not isinstance(key, str):
            raise ScenarioError(f"{entry.place}: key is missing, e.g. 'manoeuvre.0.angle_deg'")
        low = entry.number("low", -1e12, 1e12, "as the key")
        high = entry.number("high", low, 1e12, "as the key")
        entry.done()
        try:
            _put(copy.deepcopy(content), key, low)
        except (KeyError, IndexError, ValueError, TypeError):
            raise ScenarioError(f"{entry.place}: nothing in the scenario at {key!r}") from None
        yield key, low, high


def _put(content: dict[str, Any], key: str, value: float) -> None:
    *way, last = key.split(".")
    place: Any = content
    for part in way:
        place = place[int(part)] if isinstance(place, list) else place[part]
    if isinstance(place, list):
        place[int(last)] = value
    else:
        place[last] = value
