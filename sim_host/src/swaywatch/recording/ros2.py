"""ROS 2 bags: SQLite files (``.db3``), and topics of MCAP files that are in ROS's own encoding.

Every number of a message becomes a signal ``topic/field`` (nested ones with dots), as with JSON
topics of MCAP; texts and lists are left out. A message whose header has a stamp counts from then,
any other from when the bag got it. Messages are decoded by `rosbags`, an extra (``pip install
swaywatch[ros]``), with the definitions in the bag, else with those of ROS 2 itself.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import Recording, Series, must_rise
from swaywatch.recording.guard import most_unpacked, refusing

ENCODINGS = ("ros2msg", "ros2idl")
"""Of message definitions, as MCAP and SQLite bags name them."""
_NS = 1_000_000_000


class Decoder:
    """Numbers of ROS 2 messages by their type.

    Raises
    ------
    RecordingError
        Without `rosbags`.
    """

    def __init__(self, path: Path) -> None:
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise RecordingError(
                f"{path}: reading ROS 2 messages needs rosbags: pip install 'swaywatch[ros]'"
            ) from None
        self._path = path
        self._store = get_typestore(Stores.LATEST)
        self._refused: set[str] = set()

    def define(self, kind: str, encoding: str, definition: str) -> None:
        """Learn a type from the bag; types that are known already stay as they are."""
        from rosbags.typesys import get_types_from_idl, get_types_from_msg

        if kind in self._store.types or encoding not in ENCODINGS or not definition.strip():
            return
        with refusing(self._path, f"definition of {kind}"):
            if encoding == "ros2msg":
                found = get_types_from_msg(definition, kind)
            else:
                found = get_types_from_idl(definition)
            new = {name: entry for name, entry in found.items() if name not in self._store.types}
            self._store.register(new)

    def knows(self, kind: str) -> bool:
        """True where messages of this type can be decoded."""
        return kind in self._store.types

    def numbers(self, kind: str, data: bytes, time_ns: int) -> tuple[int, list[tuple[str, float]]]:
        """Time in ns since 1970 and the numbers of one message by their names."""
        message = self._store.deserialize_cdr(data, kind)
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        if stamp is not None and (stamp.sec or stamp.nanosec):
            time_ns = int(stamp.sec) * _NS + int(stamp.nanosec)
        return time_ns, list(_numbers(message, ""))


def _numbers(message: Any, name: str) -> Iterator[tuple[str, float]]:
    """Numbers of a message by the path of their fields; the header is none of its values."""
    for field in fields(message):
        value = getattr(message, field.name)
        path = f"{name}.{field.name}" if name else field.name
        if is_dataclass(value) and path != "header":
            yield from _numbers(value, path)
        elif isinstance(value, (bool, int, float, np.number)) and not field.name.startswith("_"):
            yield path, float(value)


class Collector:
    """Signals as they come, message by message."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._room = most_unpacked(path)
        self._time: dict[str, list[int]] = {}
        self._value: dict[str, list[float]] = {}

    def add(self, name: str, time_ns: int, value: float) -> None:
        """One sample."""
        self._time.setdefault(name, []).append(time_ns)
        self._value.setdefault(name, []).append(value)

    def unpack(self, size: int, what: str) -> None:
        """Refuse a file that unpacks to far more than a measurement does."""
        self._room -= size
        if self._room < 0:
            raise RecordingError(
                f"{self._path}: damaged {what}: its {self._path.stat().st_size} bytes would unpack "
                "to far more than a measurement does"
            )

    def signals(self, units: dict[str, str] | None = None) -> dict[str, Series]:
        """Everything so far."""
        found = {}
        for name, stamps in self._time.items():
            time_ns = np.array(stamps, dtype=np.int64)
            must_rise(self._path, time_ns)
            unit = (units or {}).get(name, "")
            found[name] = Series(time_ns, np.array(self._value[name]), unit)
        return found


def read(path: Path) -> Recording:
    """Read every number of a ROS 2 bag in SQLite (``.db3``)."""
    decoder, collector = Decoder(path), Collector(path)
    others: set[str] = set()
    with refusing(path, "ROS 2 bag"), closing(_open(path)) as bag:
        _define(bag, decoder)
        topics = {}
        for number, topic, kind, encoding in bag.execute(
            "SELECT id, name, type, serialization_format FROM topics"
        ):
            if encoding == "cdr" and decoder.knows(kind):
                topics[number] = (str(topic), str(kind))
            else:
                others.add(f"{topic} ({kind}, {encoding})")
        rows = bag.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id")
        for number, time_ns, data in rows:
            if number not in topics:
                continue
            topic, kind = topics[number]
            collector.unpack(len(data) + 64, "ROS 2 bag")
            stamp, values = decoder.numbers(kind, data, int(time_ns))
            for name, value in values:
                collector.add(f"{topic}/{name}", stamp, value)
    signals = collector.signals()
    left = ", ".join(sorted(others)[:6])
    if not signals:
        raise RecordingError(
            f"{path}: no number in the ROS 2 bag" + (f"; it has {left}" if left else "")
        )
    notes = (f"topics left out, since their type is not known: {left}",) if others else ()
    return Recording(path, "ROS 2 bag", signals=signals, notes=notes)


def _open(path: Path) -> sqlite3.Connection:
    """Read only, whatever the file says of journals beside it."""
    return sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)


def _define(bag: sqlite3.Connection, decoder: Decoder) -> None:
    """Definitions in the bag; before ROS 2 Iron there are none."""
    tables = {name for (name,) in bag.execute("SELECT name FROM sqlite_master WHERE type='table'")}
    if "message_definitions" not in tables:
        return
    for kind, encoding, definition in bag.execute(
        "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    ):
        decoder.define(str(kind), str(encoding), str(definition))
