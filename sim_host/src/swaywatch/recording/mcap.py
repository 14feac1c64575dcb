"""MCAP by its own library: what Foxglove and PlotJuggler open.

Written: signals that share their times are one topic ``/swaywatch/N`` of JSON messages, one field a
signal, with a JSON schema that says each one's unit. Read: every numeric field of every
JSON topic and of every ROS 2 topic (:mod:`swaywatch.recording.ros2`); fields of foreign topics are
named ``topic/field`` (nested ones with dots).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import Recording, Series
from swaywatch.recording.guard import must_fit, refusing
from swaywatch.recording.ros2 import ENCODINGS, Collector, Decoder

OWN = "/swaywatch/"


def read(path: Path) -> Recording:
    """Read every number of the JSON topics of an MCAP file."""
    from mcap.reader import make_reader

    collector = Collector(path)
    units: dict[str, str] = {}
    others: set[str] = set()
    decoder: Decoder | None = None
    with refusing(path, "MCAP"), path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        chunks = [] if summary is None else summary.chunk_indexes
        must_fit(path, sum(chunk.uncompressed_size for chunk in chunks), "MCAP")
        for schema, channel, message in reader.iter_messages():
            is_json = channel.message_encoding == "json"
            encoding = schema.encoding if schema is not None else ""
            is_ros = channel.message_encoding == "cdr" and encoding in ENCODINGS
            if not is_json and not is_ros:
                others.add(f"{channel.topic} ({channel.message_encoding})")
                continue
            collector.unpack(len(message.data) + 64, "MCAP")
            if schema is not None and not is_json:
                decoder = decoder or Decoder(path)
                decoder.define(schema.name, schema.encoding, schema.data.decode())
                time_ns, found = decoder.numbers(schema.name, message.data, message.log_time)
                for name, value in found:
                    collector.add(f"{channel.topic}/{name}", time_ns, value)
                continue
            own = channel.topic.startswith(OWN)
            if own and schema is not None and channel.topic not in units:
                units[channel.topic] = ""
                units.update(_units(schema.data))
            prefix = "" if own else f"{channel.topic}/"
            for name, value in _fields(json.loads(message.data), prefix):
                collector.add(name, message.log_time, value)
    signals = collector.signals(units)
    if not signals:
        left = f"; it has {', '.join(sorted(others)[:6])}" if others else ""
        raise RecordingError(f"{path}: no JSON or ROS 2 topic with numbers in the MCAP file{left}")
    notes = (f"topics left out, neither JSON nor ROS 2: {', '.join(sorted(others))}",)
    return Recording(path, "MCAP", signals=signals, notes=notes if others else ())


def _units(schema: bytes) -> dict[str, str]:
    properties = json.loads(schema).get("properties", {})
    return {name: str(entry.get("unit", "")) for name, entry in properties.items()}


def _fields(content: Any, prefix: str) -> list[tuple[str, float]]:
    """Numbers of a JSON message by name; texts and lists are left out."""
    found: list[tuple[str, float]] = []
    pending: list[tuple[str, Any]] = [(prefix, content)]
    while pending:
        name, item = pending.pop()
        if isinstance(item, dict):
            dot = "" if name == prefix else "."
            pending += [(f"{name}{dot}{key}", value) for key, value in reversed(item.items())]
        elif isinstance(item, (int, float)) and name != prefix:
            found.append((name, float(item)))
    return found


def write(path: Path, signals: dict[str, Series]) -> None:
    """Write decoded signals, compressed; times are nanoseconds since 1970."""
    from mcap.writer import Writer

    groups: dict[str, list[str]] = {}
    for name, topic in topics(signals).items():
        groups.setdefault(topic, []).append(name)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="swaywatch")
        rows: list[tuple[int, int, list[str], int]] = []
        for topic, names in groups.items():
            channel = _topic(writer, topic, names, signals)
            stamps = signals[names[0]].time_ns
            rows += [(int(stamp), channel, names, row) for row, stamp in enumerate(stamps)]
        rows.sort(key=lambda row: row[0])
        for stamp, channel, names, row in rows:
            values = {n: float(signals[n].value[row]) for n in names}
            content = {n: v for n, v in values.items() if np.isfinite(v)}  # JSON has no NaN
            writer.add_message(
                channel_id=channel, log_time=stamp, publish_time=stamp,
                data=json.dumps(content, separators=(",", ":"), allow_nan=False).encode(),
            )  # fmt: skip
        writer.finish()  # type: ignore[no-untyped-call]


def topics(signals: dict[str, Series]) -> dict[str, str]:
    """Topic of each signal in the file that is written of them."""
    numbers: dict[bytes, int] = {}
    return {
        name: f"{OWN}{numbers.setdefault(series.time_ns.tobytes(), len(numbers))}"
        for name, series in signals.items()
    }


def _topic(writer: Any, topic: str, names: list[str], signals: dict[str, Series]) -> int:
    properties = {
        name: {"type": "number", "unit": signals[name].unit, "description": signals[name].comment}
        for name in names
    }
    schema = writer.register_schema(
        name=f"swaywatch.Signals{topic.removeprefix(OWN)}", encoding="jsonschema",
        data=json.dumps({"type": "object", "properties": properties}).encode(),
    )  # fmt: skip
    return int(writer.register_channel(topic=topic, message_encoding="json", schema_id=schema))
