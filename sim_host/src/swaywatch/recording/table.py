"""Tables by pyarrow: CSV and Parquet, of decoded signals or of CAN frames.

Signals: a first column ``time_s`` (also ``time``, ``timestamp``, ``t``, with ``[s]``, ``[ms]``,
``[us]``, ``[ns]``) and one column for each signal, named ``Name [unit]``; an empty cell is "not
sampled then". Frames: columns ``time_ns``, ``identifier``, ``extended``, ``bus``, ``data`` (hex).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import (
    Frames,
    IntArray,
    Recording,
    Series,
    in_time_order,
    make_frames,
)
from swaywatch.recording.guard import refusing

_NAME = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
_TIME = re.compile(
    r"^(time|timestamp|timestamps|t|zeit)(?:_(?P<suffix>s|ms|us|ns))?$", re.IGNORECASE
)
_TO_NS = {"": 1e9, "s": 1e9, "sec": 1e9, "ms": 1e6, "us": 1e3, "µs": 1e3, "ns": 1.0}
_FRAME_COLUMNS = ("time_ns", "identifier", "extended", "bus", "data")


def read_csv(path: Path) -> Recording:
    """Read a CSV of signals or of frames; separator comma, semicolon or tab."""
    raw = path.read_bytes()
    head_end = raw.find(b"\n")
    head = raw[: head_end if head_end >= 0 else len(raw)]
    if b"\0" in raw[:65536]:
        raise RecordingError(f"{path}: not a CSV file: it holds binary data")
    delimiter = max((",", ";", "\t"), key=lambda mark: head.count(mark.encode()))
    with refusing(path, "CSV"):
        table = pyarrow.csv.read_csv(
            path,
            parse_options=pyarrow.csv.ParseOptions(delimiter=delimiter),
            convert_options=pyarrow.csv.ConvertOptions(
                decimal_point="," if delimiter == ";" and b"," in raw[head_end:][:4096] else ".",
                column_types={"data": pa.string()},
            ),
        )
    return _from_table(path, "CSV", table)


def read_parquet(path: Path) -> Recording:
    """Read a Parquet of signals or of frames."""
    with refusing(path, "Parquet"):
        table = pyarrow.parquet.read_table(path)
    return _from_table(path, "Parquet", table)


def write_csv(path: Path, content: Frames | dict[str, Series]) -> None:
    """Write frames or signals as CSV."""
    pyarrow.csv.write_csv(_to_table(content), path)


def write_parquet(path: Path, content: Frames | dict[str, Series]) -> None:
    """Write frames or signals as Parquet."""
    pyarrow.parquet.write_table(_to_table(content), path, compression="zstd")


def _from_table(path: Path, name: str, table: Any) -> Recording:
    if table.num_rows == 0 or table.num_columns < 2:
        raise RecordingError(
            f"{path}: empty {name}: {table.num_rows} rows, {table.num_columns} columns; expected "
            "a time column and at least one signal"
        )
    if set(_FRAME_COLUMNS) <= set(table.column_names):
        return _frames(path, name, table)
    time_column, factor = _time_column(path, table.column_names)
    time = _numbers(table[time_column])
    if time is None or not np.all(np.isfinite(time)):
        raise RecordingError(f"{path}: column {time_column!r} must hold numbers in every row")
    time_ns = np.rint(time * factor).astype(np.int64)
    if np.any(np.diff(time_ns) < 0):
        row = int(np.argmax(np.diff(time_ns) < 0)) + 2
        raise RecordingError(
            f"{path}: time goes back at row {row + 1} ({time[row - 2]:g} -> {time[row - 1]:g}); "
            "timestamps must rise"
        )
    signals: dict[str, Series] = {}
    for column in table.column_names:
        if column == time_column:
            continue
        value = _numbers(table[column])
        if value is None:
            continue
        there = np.isfinite(value)
        match = _NAME.match(column)
        assert match is not None
        unit = match["unit"] or _field_unit(table, column)
        signals[match["name"]] = Series(time_ns[there], value[there], unit)
    if not signals:
        raise RecordingError(f"{path}: no column but {time_column!r} holds numbers")
    return Recording(path, name, signals=signals)


def _field_unit(table: Any, column: str) -> str:
    metadata = table.schema.field(column).metadata or {}
    return str(metadata.get(b"unit", b"").decode("utf-8", "replace"))


def _numbers(column: Any) -> Any:
    kind = column.type
    if pa.types.is_null(kind):
        return None
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        return None
    return pc.cast(column, pa.float64()).to_numpy(zero_copy_only=False)


def _time_column(path: Path, names: list[str]) -> tuple[str, float]:
    for column in names:
        match = _NAME.match(column)
        assert match is not None
        time = _TIME.match(match["name"])
        if time:
            unit = (match["unit"] or time["suffix"] or "").strip()
            if unit not in _TO_NS:
                raise RecordingError(
                    f"{path}: time column {column!r} is in {unit!r}; known: s, ms, us, ns"
                )
            return column, _TO_NS[unit]
    shown = ", ".join(repr(name) for name in names[:8])
    raise RecordingError(
        f"{path}: no time column; name one of them `time_s`. Columns there: {shown}"
    )


def _frames(path: Path, name: str, table: Any) -> Recording:
    empty = [column for column in _FRAME_COLUMNS[:4] if table[column].null_count]
    if empty:
        raise RecordingError(f"{path}: damaged {name}: column {empty[0]!r} has empty cells")
    with refusing(path, name):
        texts = table["data"].to_pylist()
        width = max(8, max((len(text or "") for text in texts), default=0) // 2)
        data = bytes.fromhex("".join((text or "").ljust(2 * width, "0") for text in texts))
        frames = make_frames(
            table["time_ns"].to_numpy(),
            table["identifier"].to_numpy(),
            np.array(table["extended"].to_pylist(), dtype=np.bool_),
            [len(text or "") // 2 for text in texts],
            np.frombuffer(data, dtype=np.uint8).reshape(len(texts), width),
            table["bus"].to_numpy(),
        )
    frames, notes = in_time_order(frames, path)
    return Recording(path, name, frames=frames, notes=notes)


def _to_table(content: Frames | dict[str, Series]) -> Any:
    if isinstance(content, Frames):
        hexes = content.data.tobytes().hex().upper()
        stride = 2 * content.data.shape[1]
        texts = [
            hexes[row * stride : row * stride + 2 * length]
            for row, length in enumerate(content.length.tolist())
        ]
        return pa.table(
            {
                "time_ns": content.time_ns,
                "identifier": content.identifier,
                "extended": content.extended,
                "bus": content.bus,
                "data": texts,
            }
        )
    times: IntArray = np.unique(np.concatenate([s.time_ns for s in content.values()]))
    columns: dict[str, Any] = {"time_s": times * 1e-9}
    fields = [pa.field("time_s", pa.float64(), metadata={"unit": "s"})]
    for name, series in content.items():
        column = np.full(len(times), np.nan)
        column[np.searchsorted(times, series.time_ns)] = series.value
        label = f"{name} [{series.unit}]"
        columns[label] = pa.array(column, from_pandas=True)
        fields.append(pa.field(label, pa.float64(), metadata={"unit": series.unit}))
    return pa.table(columns, schema=pa.schema(fields))
