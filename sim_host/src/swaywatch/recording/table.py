"""Tables by pyarrow: CSV and Parquet, of decoded signals or of CAN frames.

Signals: a column ``time_s`` (also ``time``, ``timestamp``, ``t``, with ``[s]``, ``[ms]``, ``[us]``,
``[ns]``, or of ISO 8601 dates) and one column for each signal, named ``Name [unit]``; an empty cell
is "not sampled then". Frames: columns ``time_ns``, ``identifier``, ``extended``, ``bus``, ``data``
(hex). What a CSV holds above its numbers is in :mod:`swaywatch.recording.csv_head`.
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
from swaywatch.recording.csv_head import CsvHead, read_head, split_name
from swaywatch.recording.frames import (
    Frames,
    IntArray,
    Recording,
    Series,
    in_time_order,
    make_frames,
    must_rise,
)
from swaywatch.recording.guard import must_fit, refusing

_TIME = re.compile(
    r"^(time|timestamp|timestamps|datetime|date_time|t|zeit)(?:_(?P<suffix>s|ms|us|ns))?$",
    re.IGNORECASE,
)
_TO_NS = {"s": 10**9, "sec": 10**9, "ms": 10**6, "us": 10**3, "µs": 10**3, "ns": 1}
_FRAME_COLUMNS = ("time_ns", "identifier", "extended", "bus", "data")
_LIKELY_STEPS = ((0.0, 0.5, "s"), (2.0, 500.0, "ms"), (2e3, 5e5, "us"), (2e6, 5e8, "ns"))
"""Usual steps between samples, as a number, that only one unit of time can mean."""
_LATEST_NS = float(1 << 62)
_LONGEST_HEX = 128


def read_csv(path: Path) -> Recording:
    """Read a CSV of signals or of frames; separator comma, semicolon or tab."""
    head = read_head(path)
    comments = 0

    def odd_row(row: Any) -> str:
        nonlocal comments
        if not row.text.lstrip().startswith("#"):
            return "error"
        comments += 1
        return "skip"

    types = {name: pa.string() for name in head.names if name in ("data", head.dates)}
    with refusing(path, "CSV"):
        table = pyarrow.csv.read_csv(
            path,
            read_options=pyarrow.csv.ReadOptions(
                column_names=list(head.names),
                skip_rows=head.lines,
                encoding=head.encoding,
            ),
            parse_options=pyarrow.csv.ParseOptions(
                delimiter=head.delimiter, invalid_row_handler=odd_row
            ),
            convert_options=pyarrow.csv.ConvertOptions(
                decimal_point=head.decimal_point,
                column_types=types,
                strings_can_be_null=True,
            ),
        )
    recording = _from_table(path, "CSV", table, head)
    count = comments + head.comments
    return recording.with_note(f"{count} comment lines left out") if count else recording


def read_parquet(path: Path) -> Recording:
    """Read a Parquet of signals or of frames."""
    with refusing(path, "Parquet"):
        file = pyarrow.parquet.ParquetFile(path)
        if "data" in file.schema_arrow.names:  # of frames: a short dictionary may make long texts
            file = pyarrow.parquet.ParquetFile(path, read_dictionary=["data"])
        names, meta = list(file.schema_arrow.names), file.metadata
        must_fit(path, 8 * meta.num_rows * len(names), "Parquet")
        groups = [meta.row_group(i) for i in range(meta.num_row_groups)]
        must_fit(path, sum(group.total_byte_size for group in groups), "Parquet")
        _must_be_unique(path, names)
        is_frames = set(_FRAME_COLUMNS) <= set(names)
        wanted = [f.name for f in file.schema_arrow if is_frames or _is_plain(f.type)]
        table = file.read(columns=wanted)
        if is_frames and pa.types.is_dictionary(table["data"].type):
            for chunk in table["data"].chunks:
                _must_be_short(path, "Parquet", chunk.dictionary)
            table = table.set_column(names.index("data"), "data", pc.cast(table["data"], "string"))
    recording = _from_table(path, "Parquet", table, None)
    return recording.with_note(_left_out(names, wanted)) if len(wanted) < len(names) else recording


def _is_plain(kind: Any) -> bool:
    return _is_number(kind) or pa.types.is_timestamp(kind)


def _is_number(kind: Any) -> bool:
    return bool(
        pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)
    )


def _left_out(names: list[str], kept: list[str]) -> str:
    lost = [name for name in names if name not in kept]
    more = f" and {len(lost) - 6} more" if len(lost) > 6 else ""
    return f"columns left out, since they hold no numbers: {', '.join(lost[:6])}{more}"


def _must_be_unique(path: Path, names: list[str]) -> None:
    seen: dict[str, str] = {}
    for name in names:
        signal = split_name(name)[0]
        if _TIME.match(signal):  # a signal of the time beside the time itself
            signal = name
        if signal in seen:
            raise RecordingError(
                f"{path}: two columns are named {signal!r} ({seen[signal]!r} and {name!r}); "
                "each signal needs a name of its own"
            )
        seen[signal] = name


def write_csv(path: Path, content: Frames | dict[str, Series]) -> None:
    """Write frames or signals as CSV."""
    pyarrow.csv.write_csv(_to_table(content), path)


def write_parquet(path: Path, content: Frames | dict[str, Series]) -> None:
    """Write frames or signals as Parquet."""
    pyarrow.parquet.write_table(_to_table(content), path, compression="zstd")


def _from_table(path: Path, name: str, table: Any, head: CsvHead | None) -> Recording:
    if table.num_rows == 0 or table.num_columns < 2:
        raise RecordingError(
            f"{path}: empty {name}: {table.num_rows} rows, {table.num_columns} columns; expected "
            "a time column and at least one signal"
        )
    _must_be_unique(path, table.column_names)
    if set(_FRAME_COLUMNS) <= set(table.column_names):
        return _frames(path, name, table)
    units = head.units if head is not None else {}
    time_column = find_time(path, table.column_names)
    time_ns, notes = _time_ns(path, time_column, table[time_column], units.get(time_column, ""))
    must_rise(path, time_ns)
    signals: dict[str, Series] = {}
    kept = [time_column]
    for column in table.column_names:
        value = _numbers(table[column]) if column != time_column else None
        if value is None:
            continue
        kept.append(column)
        there = np.isfinite(value)
        signal, unit = split_name(column)
        unit = unit or units.get(column, "") or _field_unit(table, column)
        signals[signal] = Series(time_ns[there], value[there], unit)
    if not signals:
        raise RecordingError(f"{path}: no column but {time_column!r} holds numbers")
    if len(kept) < table.num_columns:
        notes = (*notes, _left_out(table.column_names, kept))
    return Recording(path, name, signals=signals, notes=notes)


def _field_unit(table: Any, column: str) -> str:
    metadata = table.schema.field(column).metadata or {}
    return str(metadata.get(b"unit", b"").decode("utf-8", "replace"))


def _numbers(column: Any) -> Any:
    if not _is_number(column.type):
        return None
    return pc.cast(column, pa.float64(), safe=False).to_numpy(zero_copy_only=False)


def find_time(path: Path, names: list[str]) -> str:
    """The name of the column of time."""
    for column in names:
        if _TIME.match(split_name(column)[0]):
            return column
    shown = ", ".join(repr(name[:40]) for name in names[:8])
    raise RecordingError(
        f"{path}: no time column; name one of them `time_s`. Columns there: {shown}"
    )


def _time_ns(path: Path, name: str, column: Any, unit: str) -> tuple[IntArray, tuple[str, ...]]:
    """Timestamps in ns, and what had to be guessed."""
    where = f"{path}: time column {name!r}"
    if column.null_count:
        row = int(np.argmax(column.is_null().to_numpy())) + 1
        raise RecordingError(f"{where} is empty in data row {row}; every row needs a time")
    if pa.types.is_string(column.type) or pa.types.is_timestamp(column.type):
        for zone in (None, "UTC"):
            try:
                stamps = pc.cast(column, pa.timestamp("ns", zone))
                return pc.cast(stamps, pa.int64()).to_numpy(), ()
            except pa.ArrowInvalid:
                continue
        raise RecordingError(
            f"{where} holds {str(column[0].as_py())[:40]!r}; expected numbers, or dates in "
            "ISO 8601 such as 2026-01-31T12:00:00.010 or 2026-01-31T12:00:00Z, all of one kind"
        )
    if not _is_number(column.type):
        raise RecordingError(f"{where} must hold numbers in every row")
    time = _numbers(column)
    match = _TIME.match(split_name(name)[0])
    assert match is not None
    notes: tuple[str, ...] = ()
    unit = (split_name(name)[1] or match["suffix"] or unit).strip().lower()
    if not unit:
        unit, notes = _likely_unit(where, time)
    if unit not in _TO_NS:
        raise RecordingError(f"{where} is in {unit!r}; known: s, ms, us, ns")
    bad = np.flatnonzero(~(np.abs(time) * _TO_NS[unit] < _LATEST_NS))
    if len(bad):
        raise RecordingError(
            f"{where} holds {time[bad[0]]:g} {unit} in data row {int(bad[0]) + 1}, which is no time"
        )
    if pa.types.is_integer(column.type):
        return pc.cast(column, pa.int64()).to_numpy() * _TO_NS[unit], notes
    return np.rint(time * _TO_NS[unit]).astype(np.int64), notes


def _likely_unit(where: str, time: Any) -> tuple[str, tuple[str, ...]]:
    """The unit of a time that does not say it, from the usual step between samples."""
    step = np.diff(time)
    step = step[step > 0.0]
    usual = float(np.median(step)) if len(step) else 0.0
    for low, high, unit in _LIKELY_STEPS:
        if low <= usual <= high:
            if unit == "s":
                return unit, ()
            note = f"{where} has no unit; its usual step of {usual:g} is taken for {unit}"
            return unit, (f"{note}; name it time_{unit} to be sure",)
    raise RecordingError(
        f"{where} has no unit, and a usual step of {usual:g} may mean several; name it time_s, "
        "time_ms, time_us or time_ns"
    )


def _must_be_short(path: Path, name: str, texts: Any) -> None:
    """Refuse frames of more than 64 bytes, before they are padded to the longest."""
    sizes = pc.utf8_length(pc.cast(texts, "string"))
    longest = pc.max(sizes).as_py() or 0
    if longest > _LONGEST_HEX:
        raise RecordingError(
            f"{path}: damaged {name}: column 'data' holds {longest} digits; a frame has at most 64 "
            "bytes, which are 128"
        )


def _frames(path: Path, name: str, table: Any) -> Recording:
    for column in _FRAME_COLUMNS[:4]:
        if table[column].null_count:
            raise RecordingError(f"{path}: damaged {name}: column {column!r} has empty cells")
    limits = {"time_ns": 1 << 62, "identifier": 1 << 32, "bus": 1 << 8}
    columns = {}
    for column, limit in limits.items():
        if not pa.types.is_integer(table[column].type):
            raise RecordingError(f"{path}: damaged {name}: column {column!r} must hold integers")
        span = pc.min_max(table[column])
        if span["min"].as_py() < 0 or span["max"].as_py() >= limit:
            raise RecordingError(
                f"{path}: damaged {name}: column {column!r} goes from {span['min']} to "
                f"{span['max']}; expected 0 to {limit - 1}"
            )
        columns[column] = table[column].to_numpy()
    with refusing(path, name):
        _must_be_short(path, name, table["data"])
        texts = [text or "" for text in table["data"].to_pylist()]
        odd = next((text for text in texts if len(text) % 2), None)
        if odd is not None:
            raise RecordingError(f"{path}: damaged {name}: the data {odd!r} end within a byte")
        width = max(8, max(map(len, texts), default=0) // 2)
        data = bytes.fromhex("".join(text.ljust(2 * width, "0") for text in texts))
        frames = make_frames(
            columns["time_ns"],
            columns["identifier"],
            np.array(table["extended"].to_pylist(), dtype=np.bool_),
            [len(text) // 2 for text in texts],
            np.frombuffer(data, dtype=np.uint8).reshape(len(texts), width),
            columns["bus"],
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
