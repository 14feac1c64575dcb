"""The result of a survey as one table: ``survey.parquet``, a row for each run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from swaywatch.recording.guard import whole_file
from swaywatch.survey.outcome import SurveyOutcome

PLAIN = (
    ("name", pa.string()),
    ("vehicle", pa.string()),
    ("state", pa.string()),
    ("stands_out", pa.list_(pa.string())),
    ("verdict", pa.string()),
    ("mismatch", pa.float64()),
    ("mismatch_after", pa.float64()),
    ("effects", pa.list_(pa.string())),
    ("why", pa.list_(pa.string())),
    ("where", pa.list_(pa.string())),
    ("conclusion", pa.string()),
    ("alarm", pa.string()),
    ("v_crit_kmh", pa.float64()),
    ("v_crit_se_kmh", pa.float64()),
    ("duration_s", pa.float64()),
    ("key", pa.string()),
)
COST = (("cpu_s", pa.float64()), ("memory_mb", pa.float64()))
"""Columns that differ from one survey of the same files to the next."""


def write_table(path: Path, outcomes: Sequence[SurveyOutcome]) -> None:
    """Write the table.

    Parameters
    ----------
    path : of the Parquet file
    outcomes : its rows, in their order; each value of the analysis has three columns: itself,
        ``_se`` (standard error), ``_believed`` (of vehicle.toml)
    """
    columns = {name: pa.array([getattr(o, name) for o in outcomes], kind) for name, kind in PLAIN}
    for name in sorted({name for o in outcomes for name in o.values}):
        found = [o.values.get(name, [None, None, None]) for o in outcomes]
        for place, suffix in enumerate(("", "_se", "_believed")):
            columns[f"{name}{suffix}"] = pa.array([entry[place] for entry in found], pa.float64())
    for name, kind in COST:
        columns[name] = pa.array([getattr(o, name) for o in outcomes], kind)
    with whole_file(path) as temporary:
        pq.write_table(pa.table(columns), temporary)
