"""Roles for the signals of a foreign recording: by names, by units, and by physics between them.

A name proposes and a unit must allow; where several could be meant, and for the signs, the motion
itself decides: lateral acceleration is speed times yaw rate (plus little), the steering wheel turns
before the car does, articulation is the integral of the difference of the yaw rates.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from swaywatch.drive import UNITS, canonical_unit
from swaywatch.first_files.inventory import Signal
from swaywatch.roles import CHANNELS, WHEELS

FloatArray = npt.NDArray[np.float64]

RATE_HZ = 20.0
SLOWEST_M_S = 5.0
CLEAR = 0.6
"""Correlation from which a relation between signals is taken as seen."""
SURE, LIKELY = 0.8, 0.5
"""Confidence from which a role is taken without a question, and from which it is proposed."""

ROAD_WHEEL_M = 8.0
"""Turning radius times angle below which the angle is one of the road wheels (wheelbase), not of
the steering wheel (wheelbase times steering ratio)."""
ROAD_WHEEL = "it is the angle of the road wheels: steering_ratio = 1"

_NAMES = {
    "steering_wheel_angle": r"steer|wheel ?angle|lenk|\bswa\b|\blwi\b|\blw\b|hand ?wheel|\bdelta\b",
    "speed": r"\bspeed\b|velocity|\bvel\b|\bv\b|\bvx|\bvm\b|geschw|\bvehspd\b|kmh|\bspd\b",
    "yaw_rate": r"yaw|gier|psi ?(dot|p\b)|\br\b|\br ?\d\b|\bwz\b|gyro ?z|rate ?z|omega ?z|\brz\b",
    "lateral_acceleration": r"lat\w* ?acc|acc\w* ?(y|lat)\b|\bay\b|quer|y ?acc|\blat ?g\b",
    "articulation": r"artic|hitch ?angle|knick|coupling ?angle",
    "hitch": r"hitch|coupling|tow ?ball|\bball\b|kuppl|\bahk\b",
    "wheel": r"wheel|\bwhl\b|\bws\b|\brad\b|rim",
    "lateral_force": r"\bfy\b|lat\w* ?force|side ?force|seitenkraft",
    "vertical_load": r"\bfz\b|vert\w* ?(force|load)|wheel ?load|radlast",
}
_TRAILER = r"trailer|anh|caravan|towed|semi|\b2\b|\btrl\b|\bt ?[12] ?[lr]\b"
_NOT = (
    r"target|raw|offset|qual|valid|status|sigma|std|accuracy|dev|bias|error|set ?point|max|min|"
    r"count|temp|torque|moment|limit|grad"
)
_WHEELS = {
    "fl": r"\b(fl|lf|vl|t ?1 ?l|front ?left|left ?front)\b",
    "fr": r"\b(fr|rf|vr|t ?1 ?r|front ?right|right ?front)\b",
    "rl": r"\b(rl|lr|hl|t ?2 ?l|rear ?left|left ?rear)\b",
    "rr": r"\b(rr|hr|t ?2 ?r|rear ?right|right ?rear)\b",
}


@dataclass(frozen=True)
class Proposal:
    """What a role (a channel) is filled with.

    Attributes
    ----------
    channel, signal
        Role and name of the signal.
    unit
        To be written, where the file says none or a wrong one; None: the file's.
    sign
        -1 where the physics says so.
    confidence
        0 to 1.
    reasons
        Why.
    rivals
        Other signals that could be meant.
    also
        Signals whose mean with `signal` it is.
    """

    channel: str
    signal: str
    unit: str | None = None
    sign: float = 1.0
    confidence: float = 0.0
    reasons: tuple[str, ...] = ()
    rivals: tuple[str, ...] = ()
    also: tuple[str, ...] = ()


@dataclass
class _Candidate:
    signal: Signal
    score: float
    unit: str | None  # to be written; None: the file's own will do
    factor: float | None  # to SI; None where no unit is known
    why: list[str] = field(default_factory=list)


def words_of(name: str) -> str:
    """A signal's name as words: ``LatAccRear1`` is ``lat acc rear 1``."""
    text = name.rpartition(".")[2]
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|[_\W]+", " ", text)
    text = re.sub(r"(?<=[A-Za-z])(?=\d)|(?<=\d)(?=[A-Za-z])", " ", text)
    return " ".join(text.lower().split())


def _candidates(signals: Iterable[Signal], channel: str, pattern: str) -> list[_Candidate]:
    """Signals whose name or unit allows a role, best first."""
    found = []
    for signal in signals:
        fits = _fit(signal, channel)
        if fits is None:
            continue
        unit, factor = fits
        words = words_of(signal.name)
        score, why = 0.0, []
        if re.search(pattern, words):
            score += 3.0
            why.append("its name")
        if signal.unit and unit is None:
            score += 1.5
            why.append(f"its unit {signal.unit}")
        if re.search(_NOT, words):
            score -= 2.5
        score += 0.5 * (signal.rate_hz >= 10.0) - 2.0 * (not signal.varies)
        if score > 0.5:
            found.append(_Candidate(signal, score, unit, factor, why))
    return sorted(found, key=lambda c: -c.score)


def _fit(signal: Signal, channel: str) -> tuple[str | None, float | None] | None:
    """Unit to be written and factor to SI; None if the unit or the values forbid the role."""
    kind = CHANNELS[channel]
    known = UNITS[kind.unit]
    if not signal.unit:
        return None, None
    unit = canonical_unit(signal.unit)
    if unit not in known:
        return None
    reach = float(np.percentile(np.abs(signal.value), 99)) * known[unit] if len(signal.value) else 0
    return (None, known[unit]) if reach <= 1.2 * max(abs(kind.low), abs(kind.high)) else None


def _is_trailer(signal: Signal) -> bool:
    return bool(re.search(_TRAILER, words_of(signal.name)))


class _Motion:
    """Signals on one even time axis, while the vehicle moves."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        there = [s for s in signals if len(s.time_s) > 1]
        first = max((s.time_s[0] for s in there), default=0.0)
        last = min((s.time_s[-1] for s in there), default=0.0)
        self.time = np.arange(first, last, 1.0 / RATE_HZ)

    def __call__(self, signal: Signal, factor: float = 1.0) -> FloatArray:
        value = np.interp(self.time, signal.time_s, signal.value) * factor
        kernel = np.hanning(7) / np.hanning(7).sum()
        return np.convolve(value, kernel, mode="same") if len(value) > 7 else value


def _related(a: FloatArray, b: FloatArray, where: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """Correlation, and slope of `b` over `a`, without their means."""
    if where.sum() < 5 * RATE_HZ:
        return 0.0, 0.0
    x, y = a[where] - a[where].mean(), b[where] - b[where].mean()
    power = float(np.sum(x * x) * np.sum(y * y))
    if power <= 0.0:
        return 0.0, 0.0
    product = float(np.sum(x * y))
    return product / math.sqrt(power), product / float(np.sum(x * x))


def propose(signals: Sequence[Signal]) -> dict[str, Proposal]:
    """Roles for signals, by channel.

    Parameters
    ----------
    signals
        Of :func:`swaywatch.first_files.inventory.inventory`.
    """
    car = [s for s in signals if not _is_trailer(s)]
    trailer = [s for s in signals if _is_trailer(s)]
    wheels = _wheel_roles(signals)
    taken = {p.signal for p in wheels.values()}
    found: dict[str, Proposal] = {}
    free = [s for s in car if s.name not in taken and not _wheel_of(s)]
    speed = _one("speed", _candidates(free, "speed", _NAMES["speed"]))
    if speed is None:
        speed = _rear_wheels(wheels)
    if speed is not None:
        found["speed"] = speed
    by_name = {s.name: s for s in signals}
    _turning(found, by_name, free, "car")
    _steering(found, by_name, free)
    hitch = [s for s in signals if re.search(_NAMES["hitch"], words_of(s.name))]
    _turning(found, by_name, [s for s in trailer if s.name not in taken], "trailer")
    _hitch(found, by_name, hitch, signals)
    return {**found, **wheels}


def _rear_wheels(wheels: dict[str, Proposal]) -> Proposal | None:
    """Speed as the mean of the wheels that are not steered."""
    pair = [wheels.get(f"wheel_speed_{wheel}") for wheel in ("rl", "rr")]
    if pair[0] is None or pair[1] is None:
        return None
    why = ("no signal of its own; the mean of the rear wheels",)
    return Proposal(
        "speed", pair[0].signal, pair[0].unit, 1.0, 0.85, why, (), (pair[1].signal,)
    )  # fmt: skip


def _one(channel: str, candidates: list[_Candidate], bonus: str = "") -> Proposal | None:
    """The best candidate as a proposal."""
    if not candidates:
        return None
    best = candidates[0]
    rivals = [c for c in candidates[1:] if c.score > best.score - 1.0]
    confidence = min(0.95, best.score / 5.5) - 0.25 * bool(rivals)
    if best.factor is None:
        confidence = min(confidence, LIKELY)
    why = [*best.why, *([bonus] if bonus else [])]
    return Proposal(
        channel, best.signal.name, best.unit, 1.0, max(0.05, confidence), tuple(why),
        tuple(c.signal.name for c in rivals),
    )  # fmt: skip


def _si(proposal: Proposal, by_name: dict[str, Signal]) -> tuple[Signal, float] | None:
    signal = by_name[proposal.signal]
    known = UNITS[CHANNELS[proposal.channel].unit]
    unit = canonical_unit(proposal.unit or signal.unit)
    return (signal, known[unit] * proposal.sign) if unit in known else None


def _turning(
    found: dict[str, Proposal], by_name: dict[str, Signal], signals: Sequence[Signal], body: str
) -> None:
    """Yaw rate and lateral acceleration of a body: the pair that speed times yaw rate holds for."""
    names = (f"{body}_yaw_rate", f"{body}_lateral_acceleration")
    rates = _candidates(signals, names[0], _NAMES["yaw_rate"])
    sides = _candidates(signals, names[1], _NAMES["lateral_acceleration"])
    speed = _si(found["speed"], by_name) if "speed" in found else None
    if speed is None or not rates or not sides:
        for channel, candidates in zip(names, (rates, sides), strict=True):
            one = _one(channel, candidates)
            if one is not None:
                found[channel] = one
        return
    pairs = [(r, s, *_balance(speed, r, s)) for r in rates[:6] for s in sides[:6]]
    rate, side, correlation, slope = max(
        pairs, key=lambda pair: pair[0].score + pair[1].score + 3.0 * abs(pair[2])
    )
    seen = f"speed times yaw rate against it: correlation {correlation:+.2f}, factor {slope:+.2f}"
    found[names[0]] = _of_pair(names[0], rate, rates, correlation)
    side.why.append(seen)
    one = _of_pair(names[1], side, sides, correlation)
    turned = abs(correlation) > CLEAR and slope < 0.0
    found[names[1]] = replace(one, sign=-1.0 if turned else 1.0)
    car = found.get("car_yaw_rate")
    if body == "trailer" and car is not None:
        _same_turn(found, by_name, car)


def _of_pair(
    channel: str, chosen: _Candidate, candidates: list[_Candidate], correlation: float
) -> Proposal:
    """One of the two signals that speed times yaw rate holds for, or should."""
    clear = abs(correlation) > CLEAR
    rivals = [c for c in candidates if c is not chosen and c.score > chosen.score - 1.0]
    confidence = min(0.9, chosen.score / 5.5) + (0.1 if clear else -0.1 - 0.2 * bool(rivals))
    if chosen.factor is None:
        confidence = min(confidence, LIKELY)
    return Proposal(
        channel, chosen.signal.name, chosen.unit, 1.0, float(np.clip(confidence, 0.05, 0.98)),
        tuple(chosen.why), tuple(c.signal.name for c in rivals),
    )  # fmt: skip


def _balance(
    speed: tuple[Signal, float], rate: _Candidate, side: _Candidate
) -> tuple[float, float]:
    """Correlation of v r and a_y, and their slope; a unit that no file says is found from it."""
    motion = _Motion([speed[0], rate.signal, side.signal])
    v = motion(*speed)
    r, a = motion(rate.signal), motion(side.signal)
    correlation, slope = _related(v * r, a, v > SLOWEST_M_S)
    rates = {None: rate.factor} if rate.factor else _some("rad/s", "rad/s", "deg/s")
    sides = {None: side.factor} if side.factor else _some("m/s2", "m/s2", "g")
    options = [
        (abs(math.log(max(abs(slope) * (k or 1.0) / (f or 1.0), 1e-9))), u, w, f, k)
        for u, f in rates.items() for w, k in sides.items()
    ]  # fmt: skip
    off, unit, other, f, k = min(options, key=lambda o: o[0])
    if len(options) > 1 and (abs(correlation) < CLEAR or off > math.log(3.0)):
        return correlation, slope
    for candidate, name, factor in ((rate, unit, f), (side, other, k)):
        if name is not None:
            candidate.unit, candidate.factor = name, factor
            candidate.score += 1.5
            candidate.why.append(f"in {name}, since only so is it speed times yaw rate")
    return correlation, slope * (k or 1.0) / (f or 1.0)


def _some(quantity: str, *names: str) -> dict[str | None, float | None]:
    return {name: UNITS[quantity][name] for name in names}


def _same_turn(found: dict[str, Proposal], by_name: dict[str, Signal], car: Proposal) -> None:
    """Sign of the trailer's yaw rate: it follows the car."""
    mine = found["trailer_yaw_rate"]
    one, two = _si(car, by_name), _si(mine, by_name)
    if one is None or two is None:
        return
    motion = _Motion([one[0], two[0]])
    slow = np.ones(int(3 * RATE_HZ)) / (3 * RATE_HZ)
    a, b = (np.convolve(motion(*pair), slow, "same") for pair in (one, two))
    correlation, _ = _related(a, b, np.ones(len(a), dtype=np.bool_))
    if correlation < -CLEAR:
        for channel in ("trailer_yaw_rate", "trailer_lateral_acceleration"):
            if channel in found:
                old = found[channel]
                why = (*old.reasons, "the trailer turns with the car")
                found[channel] = replace(old, sign=-old.sign, reasons=why)


def _steering(
    found: dict[str, Proposal], by_name: dict[str, Signal], signals: Sequence[Signal]
) -> None:
    """The steering wheel: what the turn follows."""
    name = "steering_wheel_angle"
    candidates = _candidates(signals, name, _NAMES[name])
    one = _one(name, candidates)
    if one is None:
        return
    if "its name" in one.reasons:
        found[name] = one
    speed, rate, wheel = (
        _si(proposal, by_name) if proposal else None
        for proposal in (found.get("speed"), found.get("car_yaw_rate"), one)
    )
    if speed is None or rate is None or wheel is None:
        return
    motion = _Motion([speed[0], rate[0], wheel[0]])
    v = motion(*speed)
    curvature = motion(*rate) / np.maximum(v, 1.0)
    correlation, slope = _related(motion(*wheel), curvature, v > SLOWEST_M_S)
    if abs(correlation) < CLEAR:
        return
    why = [*one.reasons, f"the turn follows it: correlation {correlation:+.2f}"]
    if abs(slope) * ROAD_WHEEL_M > 1.0:
        why.append(ROAD_WHEEL)
    found[name] = replace(
        one, sign=math.copysign(1.0, correlation), confidence=min(0.98, one.confidence + 0.1),
        reasons=tuple(why),
    )  # fmt: skip


def _hitch(
    found: dict[str, Proposal],
    by_name: dict[str, Signal],
    hitch: Sequence[Signal],
    signals: Sequence[Signal],
) -> None:
    """Forces at the ball, and the articulation angle."""
    for axis, way in (("x", "longitudinal"), ("y", "lateral"), ("z", "vertical")):
        pattern = rf"\bf ?{axis}\b|{way[:4]}|\b{axis}\b"
        named = [s for s in hitch if re.search(pattern, words_of(s.name))]
        one = _one(f"hitch_{way}_force", _candidates(named, f"hitch_{way}_force", pattern))
        if one is not None:
            found[one.channel] = one
    one = _one("articulation", _candidates(signals, "articulation", _NAMES["articulation"]))
    if one is None or "its name" not in one.reasons:
        return
    found["articulation"] = one
    rates = [_si(found[c], by_name) for c in ("trailer_yaw_rate", "car_yaw_rate") if c in found]
    angle = _si(one, by_name)
    if len(rates) < 2 or angle is None or rates[0] is None or rates[1] is None:
        return
    motion = _Motion([angle[0], rates[0][0], rates[1][0]])
    change = np.gradient(motion(*angle)) * RATE_HZ
    difference = motion(*rates[0]) - motion(*rates[1])
    correlation, _ = _related(difference, change, np.ones(len(change), dtype=np.bool_))
    if abs(correlation) > CLEAR:
        why = f"its rate is the difference of the yaw rates: {correlation:+.2f}"
        found["articulation"] = replace(
            one, sign=math.copysign(1.0, correlation), confidence=min(0.98, one.confidence + 0.1),
            reasons=(*one.reasons, why),
        )  # fmt: skip


def _wheel_of(signal: Signal) -> str:
    words = words_of(signal.name)
    return next((wheel for wheel, pattern in _WHEELS.items() if re.search(pattern, words)), "")


def _wheel_roles(signals: Sequence[Signal]) -> dict[str, Proposal]:
    """Wheel speeds and wheel forces: sets of four (or two) that differ in the wheel only."""
    found: dict[str, Proposal] = {}
    for role, pattern in (
        ("wheel_speed", rf"{_NAMES['wheel']}|{_NAMES['speed']}"),
        ("wheel_lateral_force", _NAMES["lateral_force"]),
        ("wheel_vertical_load", _NAMES["vertical_load"]),
    ):
        for prefix in ("", "trailer_") if role != "wheel_speed" else ("",):
            mine = [
                s for s in signals
                if _is_trailer(s) == bool(prefix) and re.search(pattern, words_of(s.name))
            ]  # fmt: skip
            four = {}
            for wheel in WHEELS:
                channel = f"{prefix}{role}_{wheel}"
                of_wheel = [s for s in mine if _wheel_of(s) == wheel]
                one = _one(channel, _candidates(of_wheel, channel, pattern))
                if one is not None:
                    four[channel] = one
            if len(four) >= 2:
                found |= four
    return found
