"""``signals.toml`` and ``vehicle.toml`` for a recording that nobody has described yet."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.table import Table

from swaywatch.analysis import NEEDS, refuse_trailer_roles
from swaywatch.checks.quality import check_drive
from swaywatch.drive import UNITS, canonical_unit, load_drives
from swaywatch.errors import SwaywatchError
from swaywatch.first_files.inventory import Signal
from swaywatch.first_files.propose import LIKELY, ROAD_WHEEL, SURE, Proposal
from swaywatch.nearest import with_known
from swaywatch.roles import CHANNELS, WHEEL_ROLES, WHEELS
from swaywatch.vehicle_file import load_vehicle

Ask = Callable[[str, str, str], str]
_CAR_ALONE = ("speed", "car_yaw_rate", "steering_wheel_angle", "car_lateral_acceleration")
TRAILER = ("trailer_", "hitch_", "articulation")


@dataclass(frozen=True)
class Question:
    """What no recording can know.

    Attributes
    ----------
    text, unit
        As asked.
    low, high
        What makes sense.
    typical
        Of a typical vehicle.
    """

    text: str
    unit: str
    low: float
    high: float
    typical: float


QUESTIONS: dict[str, Question] = {
    "trailer": Question("was a trailer attached, 1 yes, 0 no", "", 0, 1, 0),
    "car.mass": Question("mass of the car as driven", "kg", 300, 20e3, 1700),
    "car.wheelbase": Question("its wheelbase", "m", 1.2, 8, 2.75),
    "car.front_share": Question("share of its weight on the front axle", "%", 25, 80, 54),
    "car.overhang": Question("ball behind its rear axle", "m", 0.2, 4, 1.1),
    "car.steering_ratio": Question("steering wheel angle over road wheel angle", "", 0.5, 40, 15.5),
    "car.accelerometer": Question(
        "lateral accelerometer ahead of the rear axle (0: on it)", "m", -4, 8, 1.2
    ),
    "trailer.mass": Question("mass of the trailer as driven", "kg", 100, 45e3, 1400),
    "trailer.drawbar": Question("ball to the middle of its axles", "m", 0.8, 12, 4.5),
    "trailer.axle_spacing": Question("distance of its two axles; 0: one axle", "m", 0, 3, 0),
    "trailer.nose_weight": Question("nose weight on the ball", "kg", -200, 3000, 75),
    "trailer.accelerometer": Question(
        "its lateral accelerometer ahead of the middle of its axles", "m", -4, 8, 0.0
    ),
}
"""By name; ``--set`` takes the names."""


@dataclass(frozen=True)
class Answers:
    """What is known of the vehicle.

    Attributes
    ----------
    value
        By the name of the question; None where it is open.
    guessed
        Names whose value is that of a typical vehicle.
    has_trailer
        With a trailer.
    """

    value: dict[str, float | None]
    guessed: tuple[str, ...]
    has_trailer: bool

    def __getitem__(self, name: str) -> float | None:
        return self.value.get(name)


def signal_table(signals: Sequence[Signal]) -> Table:
    """Every signal with rate, range and unit."""
    table = Table(box=None, pad_edge=False, title="signals", title_justify="left")
    for heading in ("signal", "message", "unit", "rate [Hz]", "from", "to"):
        table.add_column(heading, justify="right" if heading in ("rate [Hz]", "from", "to") else
                         "left", overflow="fold")  # fmt: skip
    for s in signals:
        low, high = (float(s.value.min()), float(s.value.max())) if len(s.value) else (0.0, 0.0)
        table.add_row(
            s.name, s.message, s.unit or "none", f"{s.rate_hz:.4g}", f"{low:.4g}", f"{high:.4g}"
        )
    return table


def proposal_table(proposals: dict[str, Proposal]) -> Table:
    """What plays which role, and why."""
    table = Table(box=None, pad_edge=False, title="\nroles", title_justify="left")
    for heading in ("role", "signal", "how sure", "because of"):
        table.add_column(heading, overflow="fold")
    for p in proposals.values():
        sure = "sure" if p.confidence >= SURE else "likely" if p.confidence >= LIKELY else "perhaps"
        name = " + ".join((p.signal, *p.also)) + (" (sign -1)" if p.sign < 0 else "")
        table.add_row(p.channel, name, sure, "; ".join(p.reasons))
    return table


def confirm(proposal: Proposal, signals: Sequence[Signal], ask: Ask) -> Proposal | None:
    """The proposal, another signal instead, or None; asked only where it is not sure."""
    name = f"role.{proposal.channel}"
    if proposal.confidence >= SURE and not proposal.rivals:
        answer = ask(name, "", proposal.signal)
    else:
        rivals = f", or {', '.join(proposal.rivals)}" if proposal.rivals else ""
        likely = proposal.confidence >= LIKELY
        answer = ask(
            name, f"{CHANNELS[proposal.channel].meaning}: {proposal.signal}{rivals}; - for none",
            proposal.signal if likely else "-",
        )  # fmt: skip
    if answer in ("-", ""):
        return None
    by_name = {s.name: s for s in signals}
    if answer not in by_name:
        raise SwaywatchError(
            f"{name}={answer}: the recording has no such signal{with_known(answer, by_name)}"
        )
    if answer != proposal.signal:
        proposal = replace(
            proposal, signal=answer, unit=None, sign=1.0, confidence=1.0, also=(),
            reasons=("your answer",),
        )  # fmt: skip
    return _with_unit(proposal, by_name[answer], ask)


def _with_unit(proposal: Proposal, signal: Signal, ask: Ask) -> Proposal | None:
    """With a unit that is known: the file's, or an answer."""
    known = UNITS[CHANNELS[proposal.channel].unit]
    unit = proposal.unit or signal.unit
    if canonical_unit(unit) in known:
        return proposal
    name = f"role.{proposal.channel}.unit"
    said = f"stated in the file: {signal.unit!r}" if signal.unit else "not stated in the file"
    answer = ask(name, f"unit of {signal.name}, {said}: {', '.join(known)}; - leaves it out", "-")
    if canonical_unit(answer) in known:
        return replace(proposal, unit=canonical_unit(answer))
    return replace(proposal, confidence=0.0, reasons=(*proposal.reasons, f"its unit: {said}"))


def missing_units(perhaps: Sequence[Proposal], signals: Sequence[Signal]) -> list[str]:
    """What to add to the command for roles left out only because the unit is not known."""
    by_name = {s.name: s for s in signals}
    lines = []
    for proposal in perhaps:
        units = UNITS[CHANNELS[proposal.channel].unit]
        stated = by_name[proposal.signal].unit
        if canonical_unit(proposal.unit or stated) in units:
            continue
        role = f"role.{proposal.channel}"
        said = f"an unknown unit, {stated!r}" if stated else "no unit"
        lines.append(
            f"  {proposal.signal} has {said}. If it is the {CHANNELS[proposal.channel].meaning}: "
            f"--set {role}={proposal.signal} --set {role}.unit={next(iter(units))} (or "
            f"{', '.join(list(units)[1:])})"
        )
    if lines:
        lines.insert(
            0,
            "Signals left out because their unit is not known; add these options and --force to "
            "assign them:",
        )
    return lines


def vehicle_answers(chosen: dict[str, Proposal], ask: Ask, *, typical: bool) -> Answers:
    """Everything about the vehicle that is asked.

    Raises
    ------
    SwaywatchError
        An answer that is no number, or outside what makes sense.
    """
    seen = any(channel.startswith(TRAILER) for channel in chosen)
    values: dict[str, float | None] = {}
    guessed = []
    values["trailer"] = _number("trailer", "1" if seen else ask("trailer", _text("trailer"), "0"))
    has_trailer = bool(values["trailer"])
    road = any(ROAD_WHEEL in p.reasons for p in chosen.values())
    for name, question in QUESTIONS.items():
        body = name.partition(".")[0]
        if name == "trailer" or (not has_trailer and (body == "trailer" or name == "car.overhang")):
            continue
        if name.endswith("accelerometer") and f"{body}_lateral_acceleration" not in chosen:
            continue
        usual = "1" if name == "car.steering_ratio" and road else ""
        answer = ask(name, _text(name), usual or (f"{question.typical:g}" if typical else ""))
        values[name] = _number(name, answer) if answer else None
        if typical and not usual and answer == f"{question.typical:g}":
            guessed.append(name)
    return Answers(values, tuple(guessed), has_trailer)


def _text(name: str) -> str:
    question = QUESTIONS[name]
    return question.text + (f" [{question.unit}]" if question.unit else "")


def _number(name: str, answer: str) -> float:
    question = QUESTIONS[name]
    try:
        value = float(answer.replace(",", "."))
    except ValueError:
        raise SwaywatchError(f"{name} = {answer!r} must be a number, {_text(name)}") from None
    if not question.low <= value <= question.high:
        raise SwaywatchError(
            f"{name} = {value:g} is out of range; expected {question.low:g} to {question.high:g} "
            f"{question.unit} ({question.text})"
        )
    return value


# --- signals.toml ---------------------------------------------------------------------------------


def signals_toml(
    chosen: dict[str, Proposal],
    perhaps: Sequence[Proposal],
    dbcs: Sequence[Path],
    folder: Path,
    answers: Answers,
) -> str:
    """Content of ``signals.toml`` in `folder`."""
    lines = [
        "# Roles of the signals (`swaywatch roles` lists them). Axes: ISO 8855,",
        "# everything positive to the left; { signal = ..., sign = -1 } inverts one.",
    ]
    if dbcs:
        names = [_quoted(os.path.relpath(dbc.resolve(), folder.resolve())) for dbc in dbcs]
        lines.append(f"dbc = {names[0] if len(names) == 1 else '[' + ', '.join(names) + ']'}")
    lines += ["", "[signals]"]
    done: set[str] = set()
    for channel, proposal in chosen.items():
        role = next((r for r in WHEEL_ROLES if channel.startswith(r + "_")), channel)
        if role in done:
            continue
        done.add(role)
        if role in WHEEL_ROLES:
            parts = [chosen.get(f"{role}_{wheel}") for wheel in WHEELS]
            cells = ", ".join(_entry(p, answers) if p else '""' for p in parts)
            lines.append(f"{role} = [{cells}]  # FL, FR, RL, RR")
        else:
            why = "; ".join(proposal.reasons)
            if role.endswith("lateral_acceleration") and "position" not in _entry(
                proposal, answers
            ):
                why += "; position = m ahead of the COG is MISSING: taken as 0"
            lines.append(f"{role} = {_entry(proposal, answers)}  # {why}")
    for proposal in perhaps:
        lines.append(
            f"# {proposal.channel} = {_entry(proposal, answers)}  # perhaps; not taken: "
            f"{'; '.join(proposal.reasons) or 'its unit is the only indication'}"
        )
    return "\n".join(lines) + "\n"


def _entry(proposal: Proposal, answers: Answers) -> str:
    """A signal in TOML, with what is needed beside its name."""
    names = (proposal.signal, *proposal.also)
    signal = _quoted(names[0]) if len(names) == 1 else f"[{', '.join(map(_quoted, names))}]"
    extra = []
    if proposal.channel.endswith("lateral_acceleration"):
        place = _accelerometer(proposal.channel.partition("_")[0], answers)
        if place is not None:
            extra.append(f"position = {place:.3f}")
    if proposal.unit is not None:
        extra.append(f"unit = {_quoted(proposal.unit)}")
    if proposal.sign < 0.0:
        extra.append("sign = -1")
    return f"{{ signal = {signal}, {', '.join(extra)} }}" if extra else signal


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _accelerometer(body: str, answers: Answers) -> float | None:
    """Place of an accelerometer ahead of the centre of gravity, m."""
    place = answers[f"{body}.accelerometer"]
    behind = _lengths(answers).get(f"{body}.rear_to_cog")
    return None if place is None or behind is None else place - behind


# --- vehicle.toml ---------------------------------------------------------------------------------


def _lengths(answers: Answers) -> dict[str, float]:
    """Distances from the centres of gravity; of the trailer to the middle of its axles."""
    found: dict[str, float] = {}
    base, share = answers["car.wheelbase"], answers["car.front_share"]
    if base is not None and share is not None:
        found["car.front_to_cog"] = base * (1.0 - share / 100.0)
        found["car.rear_to_cog"] = base * share / 100.0
    mass, bar = answers["trailer.mass"], answers["trailer.drawbar"]
    nose = answers["trailer.nose_weight"]
    if mass is not None and bar is not None and nose is not None:
        found["trailer.rear_to_cog"] = bar * nose / mass
        found["trailer.hitch_to_cog"] = bar * (1.0 - nose / mass)
    return found


def _car_rows(answers: Answers) -> list[tuple[str, float | None, str, str]]:
    lengths = _lengths(answers)
    mass = answers["car.mass"]
    front, rear = lengths.get("car.front_to_cog"), lengths.get("car.rear_to_cog")
    inertia = None if None in (mass, front, rear) else 0.9 * mass * front * rear  # type: ignore[operator]
    over = answers["car.overhang"]
    rows = [
        ("mass", mass, "car.mass", "kg, with fuel and crew: scales, +-1.5 %"),
        ("yaw_inertia", inertia, "car.mass",
         "kg m2, about 0.9 x mass x the next two: +-15 % until measured"),
        ("front_axle_to_cog", front, "car.front_share", "m, from the axle loads: +-0.03"),
        ("rear_axle_to_cog", rear, "car.front_share", "m, from the axle loads: +-0.03"),
        ("steering_ratio", answers["car.steering_ratio"], "car.steering_ratio",
         "steering wheel over road wheel: +-3 %; 1 if the signal is the road wheels' angle"),
    ]  # fmt: skip
    if answers.has_trailer:
        ball = None if rear is None or over is None else rear + over
        rows.append(("hitch_to_cog", ball, "car.overhang", "m, ball behind the COG: +-0.03"))
    return rows


def _trailer_rows(answers: Answers) -> list[tuple[str, float | None, str, str]]:
    lengths = _lengths(answers)
    mass, hitch = answers["trailer.mass"], lengths.get("trailer.hitch_to_cog")
    behind, spacing = lengths.get("trailer.rear_to_cog"), answers["trailer.axle_spacing"]
    inertia = None if mass is None or hitch is None else mass * (0.45 * hitch) ** 2
    half = None if behind is None or spacing is None else 0.5 * spacing
    rows = [
        ("mass", mass, "trailer.mass", "kg, with its load: scales, +-1.5 %"),
        ("yaw_inertia", inertia, "trailer.mass",
         "kg m2, about mass x (0.45 x hitch_to_cog)^2: +-20 % until measured"),
        ("hitch_to_cog", hitch, "trailer.nose_weight", "m, ball ahead of the COG: +-0.05"),
        ("rear_axle_to_cog", None if half is None or behind is None else behind + half,
         "trailer.nose_weight", "m, rear (or only) axle behind the COG, from the nose weight: "
         "+-0.05"),
    ]  # fmt: skip
    if half:
        rows.append(
            ("front_axle_to_cog", None if behind is None else half - behind,
             "trailer.nose_weight", "m, front axle ahead of the COG: +-0.05")
        )  # fmt: skip
    return rows


def vehicle_toml(answers: Answers) -> str:
    """Content of ``vehicle.toml``; what is not known is left as a comment."""
    lines = [
        "# Known values of the vehicle, SI units. The tolerances in the comments are what such",
        "# values usually have; the closer to the truth, the smaller the error of the critical "
        "speed.",
    ]
    for table, rows in (
        ("car", _car_rows(answers)),
        ("trailer", _trailer_rows(answers) if answers.has_trailer else []),
    ):
        if rows:
            lines += ["", f"[{table}]"]
        for key, value, source, comment in rows:
            guess = "GUESS, a typical vehicle: replace; " if source in answers.guessed else ""
            if value is None:
                lines.append(f"# {key} =   # MISSING, {comment}")
            else:
                lines.append(f"{key} = {_figure(value)}  # {guess}{comment}")
    lines += [
        "", "# Cornering stiffness (N/rad, both wheels of an axle) is identified where the signals",
        "# allow; what you know of it goes into the tables: front_cornering_stiffness, rear_...",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _figure(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.4g}"


# --- what can be answered -------------------------------------------------------------------------


def what_can_be_answered(chosen: dict[str, Proposal], answers: Answers) -> list[str]:
    """One line for each result: had, from fewer signals, or not."""
    lines = ["", "With these signals:"]
    never = {"speed", "car_yaw_rate"} - set(chosen)
    if never:
        return [
            *lines,
            f"  stability cannot be assessed: no signal for {', '.join(sorted(never))}",
        ]
    for result, _, needed in NEEDS:
        if not answers.has_trailer and "trailer" in result:
            continue
        mine = [n for n in needed if answers.has_trailer or not n.startswith(TRAILER)]
        lacking = [n for n in mine if n not in chosen]
        if not lacking:
            lines.append(f"  yes      {result}")
            continue
        loads = "load" in result
        word = "no      " if loads or "inertia" in result else "perhaps "
        lines.append(f"  {word} {result} (better with {_short(lacking)})")
    able = {"speed", "car_yaw_rate", "steering_wheel_angle", "car_lateral_acceleration"} - set(
        chosen
    )
    lines.append(
        "  yes      diagnose: missing physics of a simulation, faulty sensors" if not able
        else f"  perhaps  diagnose (better with {_short(sorted(able))})"
    )  # fmt: skip
    guessed = [n for n in answers.guessed if n in QUESTIONS]
    if guessed:
        lines.append(
            f"  {len(guessed)} values are guesses of a typical vehicle ({', '.join(guessed)}): the "
            "critical speed is no more accurate than they are"
        )
    open_ones = [name for name, value in answers.value.items() if value is None]
    if open_ones:
        lines.append(
            f"  vehicle.toml is not complete: {', '.join(open_ones)} (fill in, or --set NAME=VALUE)"
        )
    return lines


def _short(names: Sequence[str]) -> str:
    ends = tuple(f"_{wheel}" for wheel in WHEELS)
    return ", ".join(dict.fromkeys(n[:-3] if n.endswith(ends) else n for n in names))


def check(recordings: Sequence[Path], folder: Path) -> list[str]:
    """What the checks of the data say with the two files, where they are complete."""
    try:
        vehicle = load_vehicle(folder / "vehicle.toml")
        refuse_trailer_roles(vehicle, folder / "signals.toml")
        drives = load_drives(list(recordings), folder / "signals.toml")
    except SwaywatchError as error:
        return ["", f"Not ready yet: {error}"]
    found: list[str] = []
    for drive in drives:
        findings: list[Any] = check_drive(drive, vehicle) if drive.channels else []
        found += [f"  {f.severity}: {f.text}" for f in findings if f.severity != "info"]
    names = " ".join(str(path) for path in recordings)
    ready = (
        f"Next: swaywatch analyze {names} --vehicle {folder / 'vehicle.toml'} "
        f"--signals {folder / 'signals.toml'}"
    )
    return ["", *(["Checks of the data:", *dict.fromkeys(found)] if found else []), ready]
