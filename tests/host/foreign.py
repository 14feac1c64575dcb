"""Mistakes that people make with foreign recordings, generated.

Formats, times, units, names, signs, files: each case takes a drive whose answer is known, spoils
one thing as a user would, and runs ``swaywatch analyze`` on it. It must end in one of three ways:
refused with a message, the right answer, or an answer with a warning. It must not end in a
traceback, a hang, or a wrong answer without a word. Right is an answer whose every number (critical
speed, frequency, damping, stiffnesses) is that of the clean drive within its own error; a warning
is one that the clean drive does not have::

    python tests/host/foreign.py [COUNT [SEED]]
"""

from __future__ import annotations

import collections
import contextlib
import io
import itertools
import json
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from conftest import DATA
from foreign_containers import containers

from swaywatch.cli import main
from swaywatch.drive import load_drive

P01 = DATA / "practice" / "p01"
SLOW_S = 60.0
"""A case that computes longer hangs,"""
WAIT_S = 600
"""or lasts longer, on however busy a machine."""
NEAR = 0.05
"""Relative error of the critical speed that is still the right answer;"""
OTHERS_NEAR = 0.15
"""of a frequency or a stiffness (fewer signals, coarser time), beside three standard errors."""

ROLES = {
    "speed": ("Speed", "km/h", 3.6),
    "steering_wheel_angle": ("Steer", "deg", 180 / np.pi),
    "car_yaw_rate": ("YawRate", "deg/s", 180 / np.pi),
    "car_lateral_acceleration": ("LatAcc", "m/s2", 1.0),
    "trailer_yaw_rate": ("TrailerYawRate", "deg/s", 180 / np.pi),
    "trailer_lateral_acceleration": ("TrailerLatAcc", "m/s2", 1.0),
}
"""Role: name in the file, unit there, factor from SI."""

OTHER_UNITS = {  # unit: (name, factor from the unit of the file)
    "km/h": (("m/s", 1 / 3.6), ("mph", 0.621371), ("knots", 0.539957), ("mm/s", 1000 / 3.6)),
    "deg": (("rad", np.pi / 180), ("mrad", 1000 * np.pi / 180), ("turns", 1 / 360)),
    "deg/s": (("rad/s", np.pi / 180), ("mrad/s", 1000 * np.pi / 180), ("rpm", 1 / 6)),
    "m/s2": (("g", 1 / 9.80665), ("mg", 1000 / 9.80665), ("ft/s2", 3.28084)),
}


@dataclass
class Table:
    """A recording as it will be written, and the two TOML files."""

    time: list[str]
    time_name: str
    columns: dict[str, np.ndarray]
    heads: dict[str, str]
    roles: dict[str, str]
    vehicle: str
    suffix: str = ".csv"
    delimiter: str = ","
    decimal: str = "."
    before: list[str] = field(default_factory=list)
    after_head: list[str] = field(default_factory=list)
    edit: Callable[[bytes], bytes] | None = None
    words: list[str] = field(default_factory=list)
    prepare: Callable[[Path], None] | None = None


def drive() -> Table:
    """The clean drive: 38 s of practice p01 at 50 Hz, six channels."""
    found = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    grid = found.resample(50.0)
    columns, heads, roles = {}, {}, {}
    for role, (name, unit, factor) in ROLES.items():
        columns[name] = grid.value[role] * factor
        heads[name] = f"{name} [{unit}]"
        roles[role] = f'"{name}"'
    roles["car_lateral_acceleration"] = '{ signal = "LatAcc", position = -1.383 }'
    return Table(
        [f"{t:.4f}" for t in grid.time_s], "time_s", columns, heads, roles,
        (P01 / "vehicle.toml").read_text(),
    )  # fmt: skip


def written(table: Table, folder: Path) -> list[str]:
    """The files of a case in `folder`; the words of the command line."""
    text = list(table.before)
    text.append(table.delimiter.join([table.time_name, *table.heads.values()]))
    text += table.after_head
    cells = [
        [f"{x:.6g}".replace(".", table.decimal) for x in column]
        for column in table.columns.values()
    ]
    text += [table.delimiter.join(row) for row in zip(table.time, *cells, strict=True)]
    content = ("\n".join(text) + "\n").encode("utf-8")
    if table.edit is not None:
        content = table.edit(content)
    recording = folder / f"drive{table.suffix}"
    recording.write_bytes(content)
    lines = ["[signals]", *(f"{role} = {entry}" for role, entry in table.roles.items())]
    (folder / "signals.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "vehicle.toml").write_text(table.vehicle, encoding="utf-8")
    if table.prepare is not None:
        table.prepare(folder)
    return table.words or [
        "analyze", str(recording), "--vehicle", str(folder / "vehicle.toml"),
        "--signals", str(folder / "signals.toml"), "--out", str(folder / "out"), "--no-report",
    ]  # fmt: skip


Mistake = tuple[str, Callable[[Table], None]]

# --- the mistakes: what each does to a table ------------------------------------------------------


def _scale_time(t: Table, factor: float, offset: float = 0.0, head: str = "time_s") -> None:
    t.time = [f"{(float(x) + offset) * factor:.4f}" for x in t.time]
    t.time_name = head


def _write_time(t: Table, style: str, head: str) -> None:
    t.time = [style.format(float(x)) for x in t.time]
    t.time_name = head


def _swap_rows(t: Table, k: int) -> None:
    t.time[k], t.time[k + 1] = t.time[k + 1], t.time[k]


def _repeat_time(t: Table, k: int) -> None:
    t.time[k] = t.time[k - 1]


def _jump(t: Table, k: int, by: float) -> None:
    t.time[k:] = [f"{float(x) + by:.4f}" for x in t.time[k:]]


def _restart(t: Table, k: int) -> None:
    start = float(t.time[k])
    t.time[k:] = [f"{float(x) - start:.4f}" for x in t.time[k:]]


def _set_time(t: Table, k: int, text: str) -> None:
    t.time[k] = text


def _all_times(t: Table, times: Callable[[list[str]], list[str]], head: str = "time_s") -> None:
    t.time = times(t.time)
    t.time_name = head


def _multiply(t: Table, names: tuple[str, ...], factor: float) -> None:
    for name in names:
        t.columns[name] = t.columns[name] * factor


def _say_unit(t: Table, name: str, unit: str, factor: float = 1.0) -> None:
    t.heads[name] = f"{name} [{unit}]" if unit else name
    t.columns[name] = t.columns[name] * factor


def _role(t: Table, role: str, entry: str) -> None:
    t.roles[role] = entry


def _rename_role(t: Table, role: str, wrong: str) -> None:
    t.roles[wrong] = t.roles.pop(role)


def _swap_roles(t: Table, one: str, two: str) -> None:
    t.roles[one], t.roles[two] = f'"{ROLES[two][0]}"', f'"{ROLES[one][0]}"'


def _drop_role(t: Table, role: str) -> None:
    del t.roles[role]


def _separate(t: Table, delimiter: str, decimal: str) -> None:
    t.delimiter, t.decimal = delimiter, decimal
    t.time = [x.replace(".", decimal) for x in t.time]


def _put(t: Table, **values: Any) -> None:
    for name, value in values.items():
        setattr(t, name, value)


def _bare_heads(t: Table, rows: list[str]) -> None:
    t.after_head, t.heads = rows, {name: name for name in t.heads}


def _double(t: Table) -> None:
    t.heads["Steer"] = t.heads["Speed"]


def _vehicle_text(t: Table, old: str, new: str) -> None:
    t.vehicle = t.vehicle.replace(old, new, 1)


def _swap_bodies(t: Table) -> None:
    for old, new in (("[car]", "[x]"), ("[trailer]", "[car]"), ("[x]", "[trailer]")):
        t.vehicle = t.vehicle.replace(old, new)


# --- the mistakes: families -----------------------------------------------------------------------


def _times(rng: random.Random) -> Iterator[Mistake]:
    for name, factor in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        for head in ("time", "t", "Time", "timestamp", "time_s"):
            yield f"time in {name} named {head}", partial(_scale_time, factor=factor, head=head)
        said = f"time [{name}]"
        yield f"time in {name} and said so", partial(_scale_time, factor=factor, head=said)
    yield "time since 1970", partial(_scale_time, factor=1.0, offset=1.7e9)
    yield "time since 1970 in ms", partial(_scale_time, factor=1e3, offset=1.7e9, head="time")
    for style in ("2024-05-01T10:00:{:07.4f}", "2024-05-01 10:00:{:07.4f}", "10:00:{:07.4f}",
                  "01.05.2024 10:00:{:07.4f}", "2024-05-01T10:00:{:07.4f}Z"):  # fmt: skip
        head = rng.choice(["time", "timestamp"])
        yield f"time as {style}", partial(_write_time, style=style, head=head)
    for _ in range(3):
        k = rng.randrange(300, 1500)
        yield "two rows swapped", partial(_swap_rows, k=k)
        yield "a time twice", partial(_repeat_time, k=k)
        yield "time jumps", partial(_jump, k=k, by=rng.choice([5.0, 3600.0, 1e6]))
        yield "time restarts", partial(_restart, k=k)
        yield "a time is missing", partial(_set_time, k=k, text=rng.choice(["", "nan", "-"]))
        head = rng.choice(["x", "Index", "", "A", "Sample"])
        yield f"time column named {head!r}", partial(_put, time_name=head)
        yield "row numbers as time", partial(
            _all_times, times=lambda x: [str(i) for i in range(len(x))],
            head=rng.choice(["time", "t", "timestamp"]),
        )  # fmt: skip
    yield "time runs backwards", partial(_all_times, times=lambda x: x[::-1])
    yield "time stands", partial(_all_times, times=lambda x: ["0.0"] * len(x))


def _units(rng: random.Random) -> Iterator[Mistake]:
    del rng
    for role, (name, unit, _) in ROLES.items():
        for other, factor in OTHER_UNITS[unit]:
            yield (
                f"{name} in {unit}, said to be in {other}",
                partial(_say_unit, name=name, unit=other),
            )
            yield (
                f"{name} in {other}, said to be in {unit}",
                partial(_multiply, names=(name,), factor=factor),
            )
            yield (
                f"{name} in {other} and said so",
                partial(_say_unit, name=name, unit=other, factor=factor),
            )
            entry = f'{{ signal = "{name}", unit = "{other}" }}'
            yield f"{name}: unit = {other} in signals.toml", partial(_role, role=role, entry=entry)
        for odd in ("", "?", "foo", "V", "°C", "%", "-", "1"):
            yield f"{name} in {odd or 'no unit'}", partial(_say_unit, name=name, unit=odd)


def _signs(rng: random.Random) -> Iterator[Mistake]:
    names = [name for name, _, _ in ROLES.values()]
    for count in (1, 2):
        for few in itertools.combinations(names[1:] if count == 2 else names, count):
            what = " and ".join(few)
            yield f"{what} with the wrong sign", partial(_multiply, names=few, factor=-1.0)
    for (role, (name, _, _)), sign in itertools.product(
        ROLES.items(), ("0", "2", '"minus"', "-1.5", "true")
    ):
        entry = f'{{ signal = "{name}", sign = {sign} }}'
        if rng.random() < 0.5:
            yield f"{name}: sign = {sign}", partial(_role, role=role, entry=entry)


def _names(rng: random.Random) -> Iterator[Mistake]:
    for role, (name, _, _) in ROLES.items():
        for spoilt in (name.lower(), name.upper(), name + " ", name[:-1], f"CAN1.{name}", "", "x"):
            yield f"{role} = {spoilt!r}", partial(_role, role=role, entry=f'"{spoilt}"')
        for wrong in ("yawrate", role + "s", role.upper(), "wheel_speed"):
            yield f"role {role} written {wrong}", partial(_rename_role, role=role, wrong=wrong)
        yield f"{role} not named", partial(_drop_role, role=role)
        for entry in ("3", "[]", "{}", "true", '["Speed", 3]', '{ signal = "Speed", gain = 2 }'):
            if rng.random() < 0.4:
                yield f"{role} = {entry}", partial(_role, role=role, entry=entry)
    for one, two in itertools.combinations(ROLES, 2):
        yield f"{one} and {two} swapped", partial(_swap_roles, one=one, two=two)


EDITS: dict[str, Callable[[bytes], bytes]] = {
    "byte order mark": lambda b: b"\xef\xbb\xbf" + b,
    "UTF-16": lambda b: b.decode().encode("utf-16"),
    "Latin-1 degree signs": lambda b: b.replace(b"deg", b"\xb0"),
    "CRLF": lambda b: b.replace(b"\n", b"\r\n"),
    "CR": lambda b: b.replace(b"\n", b"\r"),
    "blank lines": lambda b: b.replace(b"\n", b"\n\n"),
    "trailing delimiter": lambda b: b.replace(b"\n", b",\n"),
    "quoted": lambda b: b'"' + b.replace(b",", b'","').replace(b"\n", b'"\n"')[:-1],
    "cut in mid-line": lambda b: b[: len(b) * 2 // 3 - 7],
    "only the head": lambda b: b[: b.index(b"\n") + 1],
    "head and one row": lambda b: b"\n".join(b.split(b"\n")[:2]) + b"\n",
    "empty": lambda b: b[:0],
    "zeros": lambda b: bytes(len(b)),
    "a NUL in the middle": lambda b: b[:5000] + b"\0" + b[5000:],
    "random bytes": lambda b: random.Random(1).randbytes(len(b)),
    "no head": lambda b: b[b.index(b"\n") + 1 :],
    "head twice": lambda b: b[: b.index(b"\n") + 1] + b,
    "a row short": lambda b: b.replace(b"\n10.0000,", b"\n10.0000\n10.0100,", 1),
    "words among numbers": lambda b: b.replace(b"\n10.0000,", b"\n10.0000,Ok", 1),
    "NaN words": lambda b: b.replace(b"\n10.0000,", b"\n10.0000,NaN", 1),
    "infinite": lambda b: b.replace(b"\n10.0000,", b"\n10.0000,1e400", 1),
    "thousands marks": lambda b: b.replace(b"\n10.0000,", b"\n10.0000,1'000.", 1),
    "JSON": lambda b: json.dumps(b.decode().splitlines()).encode(),
    "HTML": lambda b: b"<html><body>" + b + b"</body></html>",
}
SUFFIXES = (".mf4", ".blf", ".asc", ".log", ".trc", ".parquet", ".txt", "", ".CSV", ".dat")
MARKS = ((";", ","), ("\t", "."), ("\t", ","), (";", "."), (",", ","), ("|", "."), (" ", "."))
UNIT_ROWS = {
    "a row of units": ["s,km/h,deg,deg/s,m/s2,deg/s,m/s2"],
    "two rows of units": ["s,km/h,deg,deg/s,m/s2,deg/s,m/s2", "-,-,-,-,-,-,-"],
    "an empty row": [""],
}


def _formats(rng: random.Random) -> Iterator[Mistake]:
    for delimiter, decimal in MARKS:
        act = partial(_separate, delimiter=delimiter, decimal=decimal)
        yield f"delimiter {delimiter!r}, decimal {decimal!r}", act
    for name, edit in EDITS.items():
        yield name, partial(_put, edit=edit)
    for (name, edit), suffix in itertools.product(EDITS.items(), SUFFIXES):
        if rng.random() < 0.25:
            put = partial(_put, edit=edit, suffix=suffix)
            yield f"{name} as {suffix or 'no suffix'}", put
    for suffix in SUFFIXES:
        yield f"CSV named {suffix or 'without suffix'}", partial(_put, suffix=suffix)
    for name, rows in UNIT_ROWS.items():
        yield name, partial(_put, after_head=rows)
        yield f"{name}, none in the head", partial(_bare_heads, rows=rows)
    for lines in (["# made by a logger"], ["# one", "# two"], ["Logger 3000", ""], ["sep=,"]):
        yield f"lines before the head: {lines}", partial(_put, before=lines)
    yield "two columns of one name", _double


def _spoilt(key: str, value: str) -> dict[str, str]:
    """Ways to get a line of vehicle.toml wrong."""
    line = f"{key} = {value}"
    found = {
        "left out": "", "in mm or g": f"{key} = {float(value) * 1000}",
        "in t or km": f"{key} = {float(value) / 1000}", "negative": f"{key} = -{value}",
        "zero": f"{key} = 0", "a text": f'{key} = "{value}"', "infinite": f"{key} = inf",
        "not a number": f"{key} = nan", "twice": f"{line}\n{line}", "with its unit": f"{line} kg",
        "huge": f"{key} = 1e300",
    }  # fmt: skip
    if "." in value:
        found["with a comma"] = f"{key} = {value.replace('.', ',')}"
    return found


def _vehicle(rng: random.Random) -> Iterator[Mistake]:
    text = (P01 / "vehicle.toml").read_text()
    for line in (line for line in text.splitlines() if " = " in line):
        key, _, value = line.partition(" = ")
        for what, new in _spoilt(key, value).items():
            if rng.random() < 0.25:
                yield f"vehicle.toml: {key} {what}", partial(_vehicle_text, old=line, new=new)
    for name, whole in {
        "empty": "", "no tables": "mass = 1\n", "not TOML": "mass: 1500\n", "JSON": "{}",
        "only [car]": "[car]\n", "a list": "[[car]]\nmass = 1500\n", "binary": "\0\1\2",
        "other tables": "[auto]\nmass = 1500\n",
        "without the trailer": text.split("[trailer]", maxsplit=1)[0],
    }.items():  # fmt: skip
        yield f"vehicle.toml: {name}", partial(_put, vehicle=whole)
    yield "car and trailer swapped", _swap_bodies


def _files(rng: random.Random) -> Iterator[Mistake]:
    del rng

    def words(*which: str) -> Callable[[Table], None]:
        def act(t: Table) -> None:
            def prepare(folder: Path) -> None:
                t.words[:] = [w.replace("@", str(folder)) for w in which]
                (folder / "folder").mkdir()
                (folder / "nobody.csv").symlink_to(folder / "nowhere")
                (folder / "empty.toml").write_text("")

            t.words, t.prepare = ["-"], prepare

        return act

    v, s = ("--vehicle", "@/vehicle.toml"), ("--signals", "@/signals.toml")
    out = ("--out", "@/out", "--no-report")
    for name, which in (
        ("no such recording", ("analyze", "@/no.csv", *v, *s, *out)),
        ("a folder as recording", ("analyze", "@/folder", *v, *s, *out)),
        ("a broken link", ("analyze", "@/nobody.csv", *v, *s, *out)),
        ("the recording twice", ("analyze", "@/drive.csv", "@/drive.csv", *v, *s, *out)),
        ("vehicle and signals swapped", ("analyze", "@/drive.csv", "--vehicle", "@/signals.toml",
                                         "--signals", "@/vehicle.toml", *out)),
        ("the recording as vehicle", ("analyze", "@/drive.csv", "--vehicle", "@/drive.csv", *s)),
        ("vehicle as recording", ("analyze", "@/vehicle.toml", *v, *s, *out)),
        ("no vehicle file", ("analyze", "@/drive.csv", "--vehicle", "@/no.toml", *s, *out)),
        ("a folder as signals", ("analyze", "@/drive.csv", *v, "--signals", "@/folder", *out)),
        ("empty signals", ("analyze", "@/drive.csv", *v, "--signals", "@/empty.toml", *out)),
        ("out is a file", ("analyze", "@/drive.csv", *v, *s, "--out", "@/drive.csv")),
        ("out below a file", ("analyze", "@/drive.csv", *v, *s, "--out", "@/drive.csv/out")),
        ("no --signals", ("analyze", "@/drive.csv", *v)),
        ("no recording", ("analyze", *v, *s)),
        ("an unknown option", ("analyze", "@/drive.csv", *v, *s, "--speed", "3")),
        ("an unknown format", ("analyze", "@/drive.csv", *v, *s, "--estimates", "xls")),
        ("analyse", ("analyse", "@/drive.csv", *v, *s)),
        ("one drive and separate", ("analyze", "@/drive.csv", *v, *s, "--one-drive", "--separate")),
        ("convert onto itself", ("convert", "@/drive.csv", "--to", "@/drive.csv")),
        ("convert to nothing known", ("convert", "@/drive.csv", "--to", "@/drive.xyz")),
        ("convert signals to frames", ("convert", "@/drive.csv", "--to", "@/drive.blf")),
        ("diagnose of nothing", ("diagnose", "@/no.csv", *v, *s, "--out", "@/d")),
        ("predict without a model", ("predict", "--model", "@/no.json", "--recording",
                                     "@/drive.csv", "--out", "@/p.json")),
        ("predict with a wrong model", ("predict", "--model", "@/vehicle.toml", "--recording",
                                        "@/drive.csv", "--out", "@/p.json")),
        ("survey of a file", ("survey", "@/drive.csv", "--out", "@/s")),
        ("survey of an empty folder", ("survey", "@/folder", "--out", "@/s")),
        ("simulate a recording", ("simulate", "@/drive.csv", "--out", "@/x.blf")),
        ("monitor a folder", ("monitor", "@/folder", *v, *s)),
        ("monitor without roles", ("monitor", "@/drive.csv", *v)),
        ("init of nothing", ("init", "@/no.csv")),
        ("init of a TOML", ("init", "@/vehicle.toml", "--out", "@/i")),
        ("iso9815 of one run", ("iso9815", "@/drive.csv", *s, "--out", "@/i")),
        ("physics of nothing", ("physics", "magic")),
    ):  # fmt: skip
        yield name, words(*which)


FAMILIES = {
    "time": _times, "unit": _units, "sign": _signs, "name": _names, "format": _formats,
    "vehicle": _vehicle, "file": _files, "container": containers,
}  # fmt: skip


def cases(count: int, seed: int) -> list[tuple[str, Mistake]]:
    """`count` mistakes, drawn evenly from all families (all of a small family)."""
    rng = random.Random(seed)
    pools = {name: list(make(rng)) for name, make in FAMILIES.items()}
    for pool in pools.values():
        rng.shuffle(pool)
    found: list[tuple[str, Mistake]] = []
    while len(found) < count and any(pools.values()):
        for name, pool in pools.items():
            if pool and len(found) < count:
                found.append((name, pool.pop()))
    return found


# --- how a case ends ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Ending:
    """``refused``, ``right``, ``warned``, ``unsaid`` (no number claimed); or the bad ones.

    ``wrong``: another answer without a word; ``traceback``; ``hang``.
    """

    kind: str
    output: str


BAD = ("wrong", "traceback", "hang")


class Hang(BaseException):
    """A case that took too long; no handler of the program catches it."""


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise Hang

    before = [(kind, signal.signal(kind, stop)) for kind in (signal.SIGPROF, signal.SIGALRM)]
    signal.setitimer(signal.ITIMER_PROF, SLOW_S)
    signal.alarm(WAIT_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.alarm(0)
        for kind, handler in before:
            signal.signal(kind, handler)


def run(table: Table, folder: Path, truth: Content) -> Ending:
    """One case; `truth` is what `summary.json` says of the clean drive."""
    words = written(table, folder)
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with _limited():
                code: int | str | None = main(words)
        except SystemExit as stop:
            code = stop.code
        except Hang:
            return Ending("hang", err.getvalue() + out.getvalue())
        except Exception as error:
            return Ending("traceback", repr(error))
    output = err.getvalue().strip() or out.getvalue().strip()
    if "Traceback" in output or "unexpected internal error" in output:
        return Ending("traceback", output)
    if code not in (0, 3):
        return Ending("refused" if output else "wrong", output)
    summary = folder / "out" / "summary.json"
    if not summary.is_file():
        return Ending("wrong", f"exit code {code} and no answer: {output}")
    drives = json.loads(summary.read_text())["drives"]
    endings = [_judged(d, truth, output) for d in drives]
    return max(endings, key=lambda e: (e.kind in BAD, e.kind == "warned"))


Content = dict[str, Any]
RESERVATIONS = ("rough guide", "Only ", "less than the", "more than the", "vehicle.toml alone")


def reservations(content: Content) -> list[str]:
    """Whatever a drive's answer says against itself."""
    loud = [f["text"] for f in content["findings"] if f["severity"] != "info"]
    return loud + [t for t in content["conclusion"] if any(d in t for d in RESERVATIONS)]


def _judged(content: Content, truth: Content, output: str) -> Ending:
    """A drive's answer beside that of the clean drive."""
    known = set(reservations(truth))
    loud = [text for text in reservations(content) if text not in known]
    if content["values"].get("v_crit_m_s") is None:
        kind = content["critical_speed"]["kind"]
        claims = kind in ("beyond_range", "below_range") and not loud
        return Ending("wrong" if claims else "unsaid", content["conclusion"][0])
    off = _off(content["values"], truth["values"])
    if off and not loud:
        return Ending("wrong", f"{', '.join(off)}: {content['conclusion'][0]}")
    return Ending("warned", "; ".join(loud)) if loud else Ending("right", output)


def _off(values: Content, true: Content) -> list[str]:
    """Numbers that are not those of the clean drive, within their errors."""
    found = []
    for name, one in values.items():
        if name not in true or name.endswith("argument_rad") or name == "model_damping_ratio":
            continue
        right, error = true[name]["value"], one["standard_error"]
        if name == "v_crit_m_s":
            room = max(NEAR * right, 2.0 * error)
        elif name == "damping_ratio":
            room = 0.02 + 3.0 * error
        else:
            room = max(OTHERS_NEAR * right, 3.0 * error)
        if not abs(one["value"] - right) <= room:
            found.append(f"{name} {one['value']:.4g} (clean {right:.4g})")
    return found


def endings(count: int, seed: int) -> Iterator[tuple[str, str, Ending, float]]:
    """Family, mistake, ending and seconds of each case; the clean drive is the first."""
    folder = Path(tempfile.mkdtemp(prefix="foreign-"))
    try:
        (folder / "clean").mkdir()
        words = written(drive(), folder / "clean")
        with contextlib.redirect_stdout(io.StringIO()):
            assert main(words) == 0
        [truth] = json.loads((folder / "clean" / "out" / "summary.json").read_text())["drives"]
        true = json.loads((P01 / "truth.json").read_text())["plant_vcrit_kmh"] / 3.6
        assert abs(truth["values"]["v_crit_m_s"]["value"] / true - 1.0) < 0.02
        assert reservations(truth) == []
        for number, (family, (name, act)) in enumerate(cases(count, seed)):
            table, place = drive(), folder / str(number)
            place.mkdir()
            act(table)
            start = time.monotonic()
            ending = run(table, place, truth)
            yield family, name, ending, time.monotonic() - start
            shutil.rmtree(place, ignore_errors=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def report(count: int, seed: int) -> int:
    """Run and tell; 1 where any case ended badly."""
    tally: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    bad = 0
    for family, name, ending, seconds in endings(count, seed):
        tally[family][ending.kind] += 1
        line = " ".join(ending.output.split())[:150]
        print(f"{ending.kind:9s} {seconds:5.1f} s  {family}: {name}  | {line}", flush=True)
        bad += ending.kind in BAD
    kinds = ("refused", "right", "warned", "unsaid", *BAD)
    print("\nfamily    " + "".join(f"{kind:>10s}" for kind in kinds))
    for family, counts in tally.items():
        print(f"{family:10s}" + "".join(f"{counts[kind]:10d}" for kind in kinds))
    total = sum((c for c in tally.values()), collections.Counter())
    print(f"{'all':10s}" + "".join(f"{total[kind]:10d}" for kind in kinds))
    return 1 if bad else 0


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    sys.exit(report(numbers[0] if numbers else 400, numbers[1] if len(numbers) > 1 else 1))
