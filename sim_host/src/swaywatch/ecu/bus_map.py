"""A map of a car's own bus for the ECU: from the DBC and the roles to `sway_map_t`, as bytes.

The ECU then reads its inputs from that bus's frames (``swaywatchd --map``). What the map says is
what ``signals.toml`` says; a CRC and a counter of a message are named in a small TOML::

    [Motion]                        # message of the DBC
    crc = "CRC_Motion"              # signal of 8 bits; CRC-8 of polynomial 0x1D (SAE J1850)
    crc_start = 0xFF                # default
    crc_final = 0xFF                # default; exclusive or at the end
    crc_prefix = [0x12, 0x34]       # bytes before the frame's own: AUTOSAR's data ID
    counter = "Counter_Motion"
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from swaywatch.drive import Mapping as Role
from swaywatch.drive import load_signals, unit_factor
from swaywatch.ecu._core import ffi, lib
from swaywatch.errors import SignalError
from swaywatch.recording.dbc import Database, invalid_codes
from swaywatch.roles import CHANNELS
from swaywatch.toml_file import load_toml

VERSION = 1
"""Of `sway_map_t`."""
MESSAGES, SIGNALS = (len(getattr(ffi.new("sway_map_t *"), part)) for part in ("message", "signal"))
NONE = 0xFFFFFFFF
LONGEST_BITS = 31
_MOST = 2**31 - 1
_NO_FIELD = (0, 0, 0, 0)


@dataclass
class BusMap:
    """A map under way.

    Attributes
    ----------
    messages : DBC messages in their order in the map
    protection : message -> its CRC and counter, words of `sway_map_message_t` after the length
    signals : words of `sway_map_signal_t`
    lines : what is in it, for the user
    positions : channel -> m ahead of the COG, that the ECU needs beside the map
    """

    messages: list[Any] = field(default_factory=list)
    protection: dict[str, tuple[int, ...]] = field(default_factory=dict)
    signals: list[tuple[int, ...]] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    positions: dict[str, float] = field(default_factory=dict)

    def to_bytes(self) -> bytes:
        """`sway_map_t`, little-endian."""
        words = struct.pack("<3I", VERSION, len(self.messages), len(self.signals))
        message = b""
        for one in self.messages:
            guard = self.protection.get(one.name, (NONE, 0, 0, 0, 0, *_NO_FIELD))
            message += struct.pack("<11I", one.frame_id, one.length, *guard)
        signal = b"".join(struct.pack("<6I5i", *one) for one in self.signals)
        words += message.ljust(44 * MESSAGES, b"\0")
        return words + signal.ljust(44 * SIGNALS, b"\0")


def make_map(signals: Path, protection: Path | None = None) -> BusMap:
    """The map of a ``signals.toml``.

    Raises
    ------
    SignalError
        What no map can hold, with the signal and what would be right.
    """
    roles, dbcs = load_signals(signals)
    if not dbcs:
        raise SignalError(f'{signals}: no DBC; a map of a bus needs one: dbc = "bus.dbc"')
    database = Database(dbcs)
    guards = {} if protection is None else load_toml(protection, SignalError, "protection")
    found = BusMap()
    for role in roles:
        _add(found, database, role, signals)
    for name, entry in guards.items():
        message = next((m for m in found.messages if m.name == name), None)
        if message is None:
            raise SignalError(f"{protection}: no role is in a message {name!r}; those with roles: "
                              f"{', '.join(m.name for m in found.messages)}")  # fmt: skip
        found.protection[name] = _guard(Path(str(protection)), message, entry)
    bare = [m.name for m in found.messages if m.name not in found.protection]
    if bare:
        found.lines.append(f"without CRC and counter: {', '.join(bare)}")
    check(found, signals)
    return found


def check(bus_map: BusMap, place: Path) -> None:
    """Refuse what the ECU's own check refuses."""
    data = bus_map.to_bytes()
    words, where = ffi.new("sway_map_t *"), ffi.new("uint32_t *")
    if len(data) != ffi.sizeof("sway_map_t"):
        raise SignalError(f"{place}: {len(bus_map.messages)} messages with {len(bus_map.signals)} "
                          f"signals; a map holds {MESSAGES} and "
                          f"{SIGNALS}")  # fmt: skip
    native = struct.pack(f"={len(data) // 4}I", *struct.unpack(f"<{len(data) // 4}I", data))
    ffi.memmove(words, native, len(native))
    if lib.sway_map_check(words, where) == lib.SWAY_OK:
        return
    number = int(where[0])
    if number < MESSAGES:
        message = bus_map.messages[number]
        raise SignalError(
            f"{place}: message {message.name} (0x{message.frame_id:X}) cannot be in a map: an "
            "identifier of ours, twice the same, or a CRC or counter that does not fit it"
        )
    if number != NONE:
        signal = bus_map.lines[number - MESSAGES]
        raise SignalError(f"{place}: {signal}: refused: outside its frame, or an input that is "
                          "there already")  # fmt: skip
    raise SignalError(f"{place}: no signal for the map")


def _add(found: BusMap, database: Database, role: Role, place: Path) -> None:
    """One role."""
    kind = CHANNELS[role.channel]
    if kind.core_input is None:
        return
    if len(role.signals) != 1:
        raise SignalError(f"{place}: {role.channel}: a mean of signals; a map takes one signal")
    name = role.signals[0]
    pair = database.find(name)
    if pair is None:
        raise SignalError(f"{place}: {role.channel} = {name!r}: no DBC has such a signal")
    message, signal = pair
    _must_fit(place, role.channel, message, signal)
    if message not in found.messages:
        found.messages.append(message)
    factor = role.factor * kind.core_scale
    factor *= unit_factor(role.channel, role.unit or signal.unit or "", name, place, place)
    ratio = _ratio(float(signal.scale) * factor)
    low, high = _raw_range(signal)
    found.signals.append(
        (found.messages.index(message), int(getattr(lib, kind.core_input)), *_field(signal),
         ratio.numerator, ratio.denominator, round(float(signal.offset) * factor), low, high)
    )  # fmt: skip
    found.lines.append(
        f"{role.channel}: {message.name}.{signal.name} (0x{message.frame_id:X}, bit {signal.start},"
        f" {signal.length} long)"
    )
    if role.channel.endswith("lateral_acceleration"):
        found.positions[role.channel] = role.position_m


def _must_fit(place: Path, channel: str, message: Any, signal: Any) -> None:
    wrong = None
    if message.is_extended_frame:
        wrong = "its identifier has 29 bits; a map takes 11"
    elif signal.multiplexer_ids:
        wrong = "it is multiplexed"
    elif signal.is_float:
        wrong = "it is a floating-point number"
    elif signal.length > LONGEST_BITS:
        wrong = f"it has {signal.length} bits; a map takes {LONGEST_BITS}"
    elif message.length > 8:
        wrong = f"its frame has {message.length} bytes; a map takes classic CAN, 8"
    if wrong:
        raise SignalError(f"{place}: {channel} = {signal.name!r}: {wrong}")


def _field(signal: Any) -> tuple[int, int, int, int]:
    """Words of `sway_map_field_t`."""
    big = int(signal.byte_order == "big_endian")
    return int(signal.start), int(signal.length), big, int(signal.is_signed)


def _ratio(value: float) -> Fraction:
    """A factor as two whole numbers of 31 bits."""
    most = int(min(_MOST, _MOST / abs(value)))
    found = Fraction(value).limit_denominator(max(most, 1))
    return found if found != 0 else Fraction(1, _MOST)


def _raw_range(signal: Any) -> tuple[int, int]:
    """Raw values that are measurements: the DBC's range, less the codes that say there is none."""
    bits = int(signal.length)
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signal.is_signed else (
        0, (1 << bits) - 1)  # fmt: skip
    least, most = signal.minimum, signal.maximum
    if least is not None and most is not None and least < most:
        ends = sorted((end - signal.offset) / signal.scale for end in (float(least), float(most)))
        low, high = max(low, math.floor(ends[0] + 0.5)), min(high, math.floor(ends[1] + 0.5))
    for code in sorted(invalid_codes(signal)):
        if 2 * code < low + high:
            low = max(low, code + 1)
        else:
            high = min(high, code - 1)
    return low, high


def _guard(path: Path, message: Any, entry: Mapping[str, Any]) -> tuple[int, ...]:
    """Words of `sway_map_message_t` from the CRC on."""
    known = {"crc", "crc_start", "crc_final", "crc_prefix", "counter"}
    if not isinstance(entry, dict) or not entry or set(entry) - known:
        raise SignalError(f"{path}: [{message.name}] knows {', '.join(sorted(known))}")
    prefix = entry.get("crc_prefix", [])
    numbers = [entry.get("crc_start", 0xFF), entry.get("crc_final", 0xFF), *prefix]
    if len(prefix) > 2 or not all(isinstance(n, int) and 0 <= n <= 255 for n in numbers):
        raise SignalError(f"{path}: [{message.name}] crc_start, crc_final and at most two bytes of "
                          "crc_prefix must be 0 to 255")  # fmt: skip
    crc_byte = NONE
    if "crc" in entry:
        place = _field(_signal(path, message, entry["crc"]))
        first = place[0] - 7 if place[2] else place[0]
        if place[1] != 8 or first % 8:
            raise SignalError(f"{path}: [{message.name}] crc = {entry['crc']!r} must be one byte")
        crc_byte = first // 8
    counter = _NO_FIELD
    if "counter" in entry:
        counter = _field(_signal(path, message, entry["counter"]))
    whole = int.from_bytes(bytes(prefix), "little")
    return (crc_byte, numbers[0], numbers[1], whole, len(prefix), *counter)


def _signal(path: Path, message: Any, name: Any) -> Any:
    for signal in message.signals:
        if signal.name == name:
            return signal
    raise SignalError(f"{path}: [{message.name}] has no signal {name!r}; it has: "
                      f"{', '.join(s.name for s in message.signals)}")  # fmt: skip
