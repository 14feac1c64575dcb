"""Foreign mistakes in real files of every format: frames with a DBC, and decoded signals.

The same drive as in `foreign`, written by the package's own writers as BLF, ASC, candump, TRC, MF4,
CSV and Parquet frames or as MF4, Parquet, MATLAB and MCAP signals, and then spoilt: its bytes, its
times, its identifiers, its units and signs, its DBC, its name.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from conftest import DATA

from swaywatch.drive import load_drive
from swaywatch.ecu.bus import DBC_PATH
from swaywatch.recording import Series, read_recording, write_recording
from swaywatch.recording.frames import Frames

P01 = DATA / "practice" / "p01"
DBC = DATA / "practice" / "measurement.dbc"
OF_FRAMES = (".blf", ".asc", ".log", ".trc", ".mf4", ".csv", ".parquet")
OF_SIGNALS = (".mf4", ".parquet", ".mat", ".mcap")
RATE_HZ = 50.0

Signals = dict[str, Series]


@cache
def frames() -> Frames:
    """The drive as CAN frames."""
    found = read_recording(P01 / "run1.blf").frames
    assert found is not None
    return found


@cache
def signals() -> Signals:
    """The drive as decoded signals, in the units of the DBC."""
    grid = load_drive([P01 / "run1.blf"], P01 / "signals.toml").resample(RATE_HZ)
    time = 1_700_000_000_000_000_000 + np.rint(grid.time_s * 1e9).astype(np.int64)
    wanted = (
        ("speed", "Speed", "km/h", 3.6), ("steering_wheel_angle", "Steer", "rad", 1.0),
        ("car_yaw_rate", "YawRate", "rad/s", 1.0),
        ("car_lateral_acceleration", "LatAcc", "m/s2", 1.0),
        ("trailer_yaw_rate", "TrailerYawRate", "rad/s", 1.0),
        ("trailer_lateral_acceleration", "TrailerLatAcc", "m/s2", 1.0),
    )  # fmt: skip
    return {name: Series(time, grid.value[role] * f, unit) for role, name, unit, f in wanted}


ROLES = """[signals]
speed = "Speed"
steering_wheel_angle = "Steer"
car_yaw_rate = "YawRate"
car_lateral_acceleration = { signal = "LatAcc", position = -1.383 }
trailer_yaw_rate = "TrailerYawRate"
trailer_lateral_acceleration = "TrailerLatAcc"
"""


def _roles_of_frames() -> str:
    return (P01 / "signals.toml").read_text().replace('"../measurement.dbc"', f'"{DBC}"')


Write = Callable[[Path, str], None]
"""Writes the recording, and its roles, into a folder; the suffix."""


def _case(table: Any, write: Write, suffix: str, named: str) -> None:
    """Make a case of a table: its files are written by `write`, the recording is called `named`."""
    words = ["-"]

    def prepare(folder: Path) -> None:
        write(folder, suffix)
        made, shown = folder / f"real{suffix}", folder / f"real{named}"
        if made != shown:
            made.rename(shown)
        words[:] = [
            "analyze", str(shown), "--vehicle", str(folder / "vehicle.toml"), "--signals",
            str(folder / "signals.toml"), "--out", str(folder / "out"), "--no-report",
        ]  # fmt: skip

    table.words, table.prepare = words, prepare


def _written(
    folder: Path,
    suffix: str,
    content: Callable[[], Frames | Signals],
    roles: Callable[[], str],
    edit: Callable[[bytes], bytes] | None = None,
) -> None:
    path = folder / f"real{suffix}"
    write_recording(path, content())
    if edit is not None:
        path.write_bytes(edit(path.read_bytes()))
    (folder / "signals.toml").write_text(roles(), encoding="utf-8")


# --- bytes ----------------------------------------------------------------------------------------


def _flipped(data: bytes, count: int, seed: int) -> bytes:
    rng, changed = random.Random(seed), bytearray(data)
    for _ in range(count):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _gone(data: bytes, value: int) -> bytes:
    """A twentieth in the middle overwritten."""
    start, size = len(data) // 2, len(data) // 20
    return data[:start] + bytes([value]) * size + data[start + size :]


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "cut at two thirds": lambda b: b[: len(b) * 2 // 3],
    "cut 3 bytes before its end": lambda b: b[:-3],
    "head alone": lambda b: b[:200],
    "empty": lambda b: b"",
    "one bit wrong": partial(_flipped, count=1, seed=5),
    "a hundred bits wrong": partial(_flipped, count=100, seed=6),
    "zeros in the middle": partial(_gone, value=0),
    "0xFF in the middle": partial(_gone, value=255),
    "twice in one file": lambda b: b + b,
    "as text of Windows": lambda b: b.replace(b"\n", b"\r\n"),
    "first byte lost": lambda b: b[1:],
}


# --- time and frames ------------------------------------------------------------------------------


def _timed(change: Callable[[Any], Any]) -> Callable[[], Frames]:
    def made() -> Frames:
        whole = frames()
        start = whole.time_ns[0]
        time = start + np.asarray(change((whole.time_ns - start).astype(np.float64)))
        return replace(whole, time_ns=np.rint(time).astype(np.int64))

    return made


def _jump(time: Any, by: float) -> Any:
    return time + by * (np.arange(len(time)) > len(time) // 2)


TIMES: dict[str, Callable[[Any], Any]] = {
    "time a thousand times too long": lambda t: 1e3 * t,
    "time a thousand times too short": lambda t: 1e-3 * t,
    "time 60 times too long": lambda t: 60.0 * t,
    "time jumps by an hour": partial(_jump, by=3600e9),
    "time jumps back by 5 s": partial(_jump, by=-5e9),
    "time runs backwards": lambda t: t[::-1],
    "time stands": lambda t: 0.0 * t,
    "time in steps of 0.1 s": lambda t: 1e8 * np.floor(t / 1e8),
}


def _changed(**change: Callable[[Frames], Any]) -> Callable[[], Frames]:
    def made() -> Frames:
        whole = frames()
        return replace(whole, **{key: act(whole) for key, act in change.items()})

    return made


FRAMES: dict[str, Callable[[], Frames]] = {
    "identifiers one too high": _changed(identifier=lambda f: f.identifier + np.uint32(1)),
    "29-bit identifiers": _changed(extended=lambda f: np.ones(len(f), dtype=np.bool_)),
    "bytes turned round": _changed(data=lambda f: np.ascontiguousarray(f.data[:, ::-1])),
    "frames of 4 bytes": _changed(length=lambda f: np.minimum(f.length, 4).astype(np.uint8)),
    "frames without data": _changed(length=lambda f: np.zeros(len(f), dtype=np.uint8)),
    "all data 0xFF": _changed(data=lambda f: np.full_like(f.data, 255)),
    "all data 0": _changed(data=lambda f: np.zeros_like(f.data)),
    "two buses mixed": _changed(bus=lambda f: (np.arange(len(f)) % 2).astype(np.uint8)),
}

DBCS = {
    "the wrong DBC": f'"{DBC_PATH}"',
    "no such DBC": '"nowhere.dbc"',
    "a recording as DBC": f'"{P01 / "run1.blf"}"',
    "a TOML as DBC": f'"{P01 / "vehicle.toml"}"',
    "the DBC twice": f'["{DBC}", "{DBC}"]',
    "two DBCs of one identifier": f'["{DBC}", "{DBC_PATH}"]',
}


def _roles_with(old: str, new: str) -> Callable[[], str]:
    return lambda: _roles_of_frames().replace(old, new)


ENTRIES = {  # role: (as it is, as the user spoils it)
    "yaw rate of the trailer for that of the car": ('"YawRate1"', '"YawRate2"'),
    "the yaw rates swapped": ('"YawRate1"', '"YawRate9"'),
    "the car's yaw rate turned": ('"YawRate1"', '{ signal = "YawRate1", sign = -1 }'),
    "the trailer's yaw rate turned": ('"YawRate2"', '{ signal = "YawRate2", sign = -1 }'),
    "steering turned": ('"SteeringWheelAngle"', '{ signal = "SteeringWheelAngle", sign = -1 }'),
    "steering said to be in rad": (
        '"SteeringWheelAngle"',
        '{ signal = "SteeringWheelAngle", unit = "rad" }',
    ),
    "speed said to be in m/s": ('"VehicleSpeed"', '{ signal = "VehicleSpeed", unit = "m/s" }'),
    "speed said to be in knots": ('"VehicleSpeed"', '{ signal = "VehicleSpeed", unit = "knots" }'),
    "yaw rate said to be in rad/s": ('"YawRate1"', '{ signal = "YawRate1", unit = "rad/s" }'),
    "acceleration in front of the axle": ("position = -1.383", "position = 1.383"),
    "position in mm": ("position = -1.383", "position = -1383"),
    "hitch force turned": ('"HitchFy"', '{ signal = "HitchFy", sign = -1 }'),
    "front and rear forces swapped": (
        '["FyFL", "FyFR", "FyRL", "FyRR"]',
        '["FyRL", "FyRR", "FyFL", "FyFR"]',
    ),
    "loads for forces": ('["FyFL", "FyFR", "FyRL", "FyRR"]', '["FzFL", "FzFR", "FzRL", "FzRR"]'),
    "three wheels": ('["FyFL", "FyFR", "FyRL", "FyRR"]', '["FyFL", "FyFR", "FyRL"]'),
    "a signal that is not there": ('"YawRate2"', '"YawRate22"'),
}


# --- decoded signals ------------------------------------------------------------------------------


def _with(name: str, factor: float = 1.0, unit: str | None = None) -> Callable[[], Signals]:
    def made() -> Signals:
        found = dict(signals())
        one = found[name]
        value = one.value * factor
        found[name] = Series(one.time_ns, value, one.unit if unit is None else unit)
        return found

    return made


def _clocked(change: Callable[[Any], Any]) -> Callable[[], Signals]:
    def made() -> Signals:
        found = signals()
        first = next(iter(found.values())).time_ns
        start = first[0]
        time = start + np.rint(change((first - start).astype(np.float64))).astype(np.int64)
        return {name: Series(time, one.value, one.unit) for name, one in found.items()}

    return made


def _late(name: str, by_s: float) -> Callable[[], Signals]:
    def made() -> Signals:
        found = dict(signals())
        one = found[name]
        found[name] = Series(one.time_ns + round(by_s * 1e9), one.value, one.unit)
        return found

    return made


VALUES: dict[str, Callable[[], Signals]] = {
    **{f"{name} with the wrong sign": _with(name, -1.0) for name in (
        "Speed", "Steer", "YawRate", "LatAcc", "TrailerYawRate", "TrailerLatAcc")},
    **{f"{name} in deg/s, said to be in rad/s": _with(name, 180 / np.pi) for name in (
        "YawRate", "TrailerYawRate")},
    **{f"{name} in g, said to be in m/s2": _with(name, 1 / 9.80665) for name in (
        "LatAcc", "TrailerLatAcc")},
    **{f"{name} in m/s2, said to be in g": _with(name, unit="g") for name in (
        "LatAcc", "TrailerLatAcc")},
    "Speed in m/s, said to be in km/h": _with("Speed", 1 / 3.6),
    "Speed in km/h, said to be in m/s": _with("Speed", unit="m/s"),
    "Speed without a unit": _with("Speed", unit=""),
    "Steer in deg, said to be in rad": _with("Steer", 180 / np.pi),
    "TrailerYawRate half a second late": _late("TrailerYawRate", 0.5),
    "LatAcc a minute late": _late("LatAcc", 60.0),
    "the signals a year apart": _late("Speed", 365.25 * 86400.0),
}  # fmt: skip


Mistake = tuple[str, Callable[[Any], None]]


def _made(what: str, suffix: str, write: Write, named: str = "") -> Mistake:
    kind = partial(_case, write=write, suffix=suffix, named=named or suffix)
    return f"{what} ({suffix[1:]}{f' named {named}' if named else ''})", kind


def _of_frames(rng: random.Random) -> Iterator[Mistake]:
    whole = partial(_written, content=frames, roles=_roles_of_frames)
    for suffix in OF_FRAMES:
        yield _made("frames as they are", suffix, whole)
        for what, edit in DAMAGE.items():
            yield _made(f"frames, {what}", suffix, partial(whole, edit=edit))
        for what, content in ({k: _timed(v) for k, v in TIMES.items()} | FRAMES).items():
            made = partial(_written, content=content, roles=_roles_of_frames)
            yield _made(f"frames, {what}", suffix, made)
    for (what, dbc), suffix in itertools.product(DBCS.items(), OF_FRAMES[:4]):
        roles = _roles_with(f'"{DBC}"', dbc)
        yield _made(what, suffix, partial(_written, content=frames, roles=roles))
    for what, (old, new) in ENTRIES.items():
        made = partial(_written, content=frames, roles=_roles_with(old, new))
        yield _made(what, rng.choice(OF_FRAMES), made)
    for one, two in itertools.product(OF_FRAMES, (*OF_FRAMES, ".mat", ".mcap", ".db3")):
        if one != two and rng.random() < 0.3:
            yield _made("frames", one, whole, named=two)


def _of_signals() -> Iterator[Mistake]:
    whole = partial(_written, content=signals, roles=lambda: ROLES)
    for suffix in OF_SIGNALS:
        yield _made("signals as they are", suffix, whole)
        for what, edit in DAMAGE.items():
            yield _made(f"signals, {what}", suffix, partial(whole, edit=edit))
        for what, content in ({k: _clocked(v) for k, v in TIMES.items()} | VALUES).items():
            made = partial(_written, content=content, roles=lambda: ROLES)
            yield _made(f"signals, {what}", suffix, made)


def containers(rng: random.Random) -> Iterator[Mistake]:
    """Every mistake in every format that it can be made in."""
    yield from _of_frames(rng)
    yield from _of_signals()
