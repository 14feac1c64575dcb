"""Is the recording what it says it is? Gaps, stuck or clipped signals, signs, units, delays.

Single channels are looked at on their own; signs, units and delays by relations that must hold
between channels whatever the tyres do: kinematics of the hitch, balances of forces and moments.
A relation is a sum of terms, one per channel, that is zero (band-passed 0.15-3 Hz).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.stats

from swaywatch.checks.clocks import check_rate, check_steps
from swaywatch.checks.relations import Relation, RelationBuilder, badness, make_relations
from swaywatch.checks.samples import STANDING_M_S, Finding, check_channel, check_samples, cleaned
from swaywatch.checks.sensors import check_drift, check_swapped
from swaywatch.checks.signs import (
    FACTORS,
    GRAVITY,
    check_factors,
    factor_text,
    fits_quantity,
    known_factor,
    whole_of,
)
from swaywatch.drive import Drive, Grid
from swaywatch.vehicle import Vehicle

__all__ = ["Finding", "check_balances", "check_channel", "check_drive"]

FloatArray = npt.NDArray[np.float64]

RATE_HZ = 100.0
CLEAR = 0.1
"""Rest of the balances that values of the vehicle within their tolerances seldom make; below it a
delay must explain more to be accepted."""
LATEST_S = 0.4
"""A delay is looked for within so much."""
SURE = 0.995
"""Of a line through delays: one-sided probability that its slope is none of chance."""
LIVELIEST = 12000
"""Samples (two minutes) that are enough to find a delay from."""

STEERING_WRONG = ((0.6, 0.5), (0.2, 0.15))
"""Part of the front axle's force that the steering angle leaves unexplained as it is, above which
it is wrong where no more than this part of it is left when it is put right: healthy cars on
springs, with tyres that relax and saturate, leave up to 0.5 and then gain little."""


def check_drive(drive: Drive, vehicle: Vehicle) -> list[Finding]:
    """Everything worth saying about the data, worst first.

    Parameters
    ----------
    drive, vehicle
        Masses and lengths enter the balances.
    """
    findings = check_samples(drive)
    whole, drive = drive, cleaned(drive, findings)
    findings += _check_clock(whole) or check_rate(whole)
    findings += check_steps(whole)
    findings += _check_speed(drive) or _check_wheel_speeds(drive)
    findings += _check_pairs(drive) or _check_loads(drive, vehicle)
    grid = drive.resample(RATE_HZ)
    if len(grid.time_s) >= 4 * RATE_HZ:
        findings += _check_relations(drive, vehicle, grid)
    if drive.lost_frames:
        findings.append(
            Finding(
                "warning",
                "loss",
                (),
                f"the logger lost {drive.lost_frames} frames ({', '.join(drive_files(drive))}); "
                "estimates use the remaining ones",
            )
        )
    findings += [Finding("info", "remark", (), remark) for remark in drive.remarks]
    order = {"error": 0, "warning": 1, "info": 2}
    return sorted(findings, key=lambda finding: order[finding.severity])


def _check_relations(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Finding]:
    """What the channels say of each other: signs, units, swaps; if these are right, the rest."""
    relations = make_relations(drive, vehicle, grid)
    left, swapped = check_swapped(drive, vehicle, grid, relations)
    score, wrong = check_factors(drive, relations)
    if wrong and swapped and score < left:
        swapped = []
    if swapped:
        sides = all(a[:-1] == b[:-1] for a, b in (finding.channels for finding in swapped))
        return swapped + (_check_steering(drive, vehicle, grid) if sides else [])
    right = _put_right_by(drive, wrong)
    wrong += _check_steering(right, vehicle, right.resample(RATE_HZ) if wrong else grid)
    if wrong:
        return wrong
    found = _check_two_clocks(drive, grid, relations)
    if not found:
        score, late = _check_delays(drive, grid, relations)
        found = _check_own_clock(drive, grid, relations, score) or late
    return found or check_drift(drive, vehicle, grid)


def _put_right_by(drive: Drive, wrong: list[Finding]) -> Drive:
    """The drive without the wrong signs and units."""
    channels = dict(drive.channels)
    for finding in wrong:
        for name in finding.channels[:1]:
            channel = channels[name]
            channels[name] = replace(channel, value=channel.value * finding.amount)
    return replace(drive, channels=channels)


def check_balances(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Every relation that could be checked, and its rest as part of its largest term.

    The rest tells noise (a few percent), missing physics (some ten) and wrong signals (more); of
    the rough relations only sign and order of magnitude are checked, and they are left out here.
    """
    grid = drive.resample(RATE_HZ)
    if len(grid.time_s) < 4 * RATE_HZ:
        return {}
    relations = make_relations(drive, vehicle, grid)
    return {relation.name: relation.rest() for relation in relations if relation.tight}


# --- clock, speed, loads --------------------------------------------------------------------------


def _check_clock(drive: Drive) -> list[Finding]:
    """One clock for the whole drive: the usual step of every channel must stay the same."""
    ratios = {}
    for channel in drive.channels.values():
        step = np.diff(channel.time_s)
        if len(step) < 200:
            continue
        parts = [float(np.median(part)) for part in np.array_split(step, 8)]
        ratios[channel.signal] = max(parts) / max(min(parts), 1e-9)
    if len(ratios) < 2:
        return []
    typical = float(np.median(list(ratios.values())))
    if typical < 1.02:
        return []
    return [
        Finding(
            "error",
            "clock",
            tuple(ratios),
            f"the clock changes its speed: the usual step of the messages changes by "
            f"{100 * (typical - 1):.0f} % within the drive ({', '.join(drive_files(drive))}); all "
            "timestamps must come from one clock",
        )
    ]


def drive_files(drive: Drive) -> list[str]:
    """Names of the files of a drive."""
    return [path.name for path in drive.files]


def _check_speed(drive: Drive) -> list[Finding]:
    channel = drive.channels.get("speed")
    if channel is None:
        return []
    fastest = float(np.percentile(channel.value, 99))
    if fastest > 70.0:
        return [
            Finding(
                "error",
                "sign_or_unit",
                (channel.signal,),
                f"{channel.signal}: speed reaches {fastest:.1f} m/s = {fastest * 3.6:.0f} km/h, "
                "which no car with a trailer reaches; is it in km/h, although the recording states "
                f"{channel.unit_in_file}? Set `unit = ...` in the signals.toml",
                channels=("speed",),
                windows=(whole_of(drive, "speed"),),
                amount=1 / 3.6,
            )
        ]
    if float(np.percentile(channel.value, 1)) < -0.5:
        return [
            Finding(
                "error",
                "sign_or_unit",
                (channel.signal,),
                f"{channel.signal}: speed is negative ({channel.value.min():.1f} m/s); its sign "
                "is wrong, or the car drives backwards",
                channels=("speed",),
                windows=(whole_of(drive, "speed"),),
                amount=-1.0,
            )
        ]
    return []


def _check_wheel_speeds(drive: Drive) -> list[Finding]:
    """The speed against the mean of the wheels: no slip makes a third of a difference."""
    speed = drive.channels.get("speed")
    wheels = [c for name, c in drive.channels.items() if name.startswith("wheel_speed")]
    if speed is None or not wheels:
        return []
    mean = float(np.mean([np.median(wheel.value) for wheel in wheels]))
    own = float(np.median(speed.value))
    factor = known_factor(mean / own) if min(mean, own) > STANDING_M_S else None
    if factor is None or not fits_quantity("speed", factor):
        return []
    return [
        Finding(
            "error",
            "sign_or_unit",
            (speed.signal, *(wheel.signal for wheel in wheels)),
            f"{speed.signal}: {factor_text(factor, 'speed')}. It is {own:.1f} m/s where the "
            f"wheels ({', '.join(wheel.signal for wheel in wheels)}) say {mean:.1f} m/s; correct "
            "the `unit = ...` of the wrong one in the signals.toml",
            channels=("speed",),
            windows=(whole_of(drive, "speed"),),
            amount=factor,
        )
    ]


def _check_loads(drive: Drive, vehicle: Vehicle) -> list[Finding]:
    """Mean vertical loads against the weight."""
    findings = []
    for prefix, body in (("", vehicle.car), ("trailer_", vehicle.trailer)):
        names = [f"{prefix}wheel_vertical_load_{wheel}" for wheel in ("fl", "fr", "rl", "rr")]
        if body is None or not all(name in drive.channels for name in names):
            continue
        channels = [drive.channels[name] for name in names]
        total = sum(float(np.mean(channel.value)) for channel in channels)
        weight = body.mass * GRAVITY
        ratio = total / weight
        if 0.6 < ratio < 1.5:
            continue
        signals = tuple(channel.signal for channel in channels)
        text = (
            f"{', '.join(signals)}: the wheel loads add up to {total:.0f} N, the "
            f"{'trailer' if prefix else 'car'} weighs {weight:.0f} N"
        )
        reason = factor_text(1.0 / ratio if ratio else math.inf, "load")
        findings.append(
            Finding("error", "load", signals, f"{text}; {reason}" if reason else f"{text}; check")
        )
    return findings


def _check_steering(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Finding]:
    """Sign and unit of the steering angle, from the force it makes at the front axle."""
    name = "steering_wheel_angle"
    factors = [1.0, *(factor for factor, _ in FACTORS if fits_quantity(name, factor))]
    rests = RelationBuilder(drive, vehicle, grid).steering_rests(factors)
    if rests is None:
        return []
    best, before = int(np.argmin(rests)), min(rests[0], 1.0)
    if not any(before > rest and rests[best] < gain * before for rest, gain in STEERING_WRONG):
        return []
    signal = drive.channels[name].signal
    left = "more than all" if rests[0] > 1.0 else f"{100 * rests[0]:.0f} %"
    return [
        Finding(
            "error",
            "sign_or_unit",
            (signal,),
            f"{signal}: {factor_text(factors[best], name)}. As recorded, the slip of the front "
            f"axle leaves {left} of the axle's lateral force unexplained, corrected "
            f"{100 * rests[best]:.0f} %; correct it in the signals.toml, e.g. "
            f'{name} = {{ signal = "{signal}", '
            + ("sign = -1 }" if factors[best] == -1.0 else 'unit = "..." }'),
            channels=(name,),
            windows=(whole_of(drive, name),),
            amount=factors[best],
        )
    ]


def _check_pairs(drive: Drive) -> list[Finding]:
    """Left and right wheel of an axle carry forces of the same size."""
    findings = []
    for name, left in drive.channels.items():
        right = drive.channels.get(name[:-1] + "r")
        if not name.startswith(("wheel", "trailer_wheel")) or name[-1] != "l" or right is None:
            continue
        if "speed" in name:  # both roll at the speed of the car: they hardly vary
            continue
        if "vertical" in name:
            sizes = float(np.mean(left.value)), float(np.mean(right.value))
        else:
            sizes = float(np.std(left.value)), float(np.std(right.value))
        ratio = sizes[0] / sizes[1] if sizes[1] else math.inf
        if 0.2 < ratio < 5.0:
            continue
        others = [
            float(np.mean(c.value) if "vertical" in name else np.std(c.value))
            for n, c in drive.channels.items()
            if n[:-2] == name[:-2] and n[:-1] != name[:-1]
        ]
        usual = float(np.median(others)) if others else max(sizes)
        off = int(_distance(sizes[1], usual) > _distance(sizes[0], usual))
        factor = known_factor(sizes[1 - off] / sizes[off] if sizes[off] else math.inf)
        text = factor_text(factor or 0.0, name)
        culprit = (left.name, right.name)[off]
        findings.append(
            Finding(
                "error",
                "sign_or_unit",
                (left.signal, right.signal),
                f"{left.signal} and {right.signal}, left and right of one axle, are {sizes[0]:.3g} "
                f"and {sizes[1]:.3g} N; they should be of the same size and sign"
                + (f" ({drive.channels[culprit].signal}: {text})" if text else ""),
                channels=(culprit,) if factor else (),
                windows=(whole_of(drive, culprit),),
                amount=factor or 1.0,
            )
        )
    return findings


def _distance(size: float, usual: float) -> float:
    """Powers of ten between two sizes; a wrong sign is worse than any."""
    decades = abs(math.log10(max(abs(size), 1e-9) / max(abs(usual), 1e-9)))
    return decades + (100.0 if size * usual < 0.0 else 0.0)


# --- delays ---------------------------------------------------------------------------------------


def _check_delays(
    drive: Drive, grid: Grid, relations: list[Relation]
) -> tuple[float, list[Finding]]:
    """The one channel whose shift in time lets the tight relations hold better, and their rest."""
    tight = _liveliest([relation for relation in relations if relation.tight])
    if not tight:
        return math.inf, []
    now = badness([relation.rest() for relation in tight])
    best: tuple[float, str, float] = (now, "", 0.0)
    for name in sorted(set().union(*(relation.channels for relation in tight))):
        mine = [relation for relation in tight if name in relation.channels]
        delay_s = _best_delay(mine, {name}, grid.rate_hz)
        rests = [_shifted_rest(relation, {name}, delay_s, grid.rate_hz) for relation in mine]
        others = [relation.rest() for relation in tight if name not in relation.channels]
        score = badness(rests + others)
        if score < best[0]:
            best = (score, name, delay_s)
    score, name, delay_s = best
    healthy = badness([relation.rest_of_rolling() for relation in tight])
    if not name or abs(delay_s) < 0.008 or score > 0.6 * now or now < 0.08:
        return score, []
    sure = score < (0.75 if now > CLEAR else 0.45) * healthy
    channel = drive.channels[name]
    word = "late" if delay_s > 0 else "early"
    return score, [
        Finding(
            "warning" if sure else "info",
            "delay",
            (channel.signal,),
            f"{channel.signal} comes {abs(delay_s) * 1e3:.0f} ms too {word} against the other "
            f"signals (residual of the balances {100 * now:.0f} %, shifted {100 * score:.0f} %); "
            + (
                f"correct it with `delay = {delay_s:.3f}` in the signals.toml"
                if sure
                else "or accelerometers roll with their bodies and measure gravity, which "
                f"explains as much ({100 * healthy:.0f} %)"
            ),
            channels=(name,) if sure else (),
            windows=(whole_of(drive, name),) if sure else (),
            amount=delay_s,
        )
    ]


def _check_two_clocks(drive: Drive, grid: Grid, relations: list[Relation]) -> list[Finding]:
    """Two clocks: the delay of one file's signals against the other's grows with time."""
    files = sorted({channel.files for channel in drive.channels.values()})
    tight = [relation for relation in relations if relation.tight]
    for file in files[1:] if len(files) > 1 else []:
        names = {name for name, channel in drive.channels.items() if channel.files == file}
        course = _course_of_delay(tight, names, grid, parts=3)
        if course is None:
            continue
        delays, slope = course.delays, course.slope
        if course.change > max(0.03, course.least) and _put_right(tight, names, course, grid):
            return [
                Finding(
                    "error",
                    "clock",
                    tuple(drive.channels[name].signal for name in sorted(names)),
                    f"two clocks at different rates: the signals of {', '.join(file)} run "
                    f"{100 * abs(slope):.2f} % {'slow' if slope < 0 else 'fast'} against those of "
                    f"{', '.join(files[0])} (their delay goes from {delays[0] * 1e3:+.0f} to "
                    f"{delays[-1] * 1e3:+.0f} ms); put the files on one clock first",
                )
            ]
    return []


def _check_own_clock(
    drive: Drive, grid: Grid, relations: list[Relation], shifted: float
) -> list[Finding]:
    """A single signal, or all of one message, whose delay grows with time.

    `shifted` is the rest of the balances with the best delay that stays the same.
    """
    tight = [relation for relation in relations if relation.tight]
    now = badness([relation.rest() for relation in tight]) if tight else 0.0
    if now < 0.06:
        return []
    best: tuple[float, float, float, list[str]] = (min(0.6 * now, 0.85 * shifted), 0.0, 0.0, [])
    for names in _on_one_clock(drive, set().union(*(relation.channels for relation in tight))):
        course = _course_of_delay(tight, names, grid, parts=4)
        if course is None or course.change < max(0.015, course.least):
            continue
        score = _rest_on_course(tight, names, course, grid)
        if score < best[0]:
            best = (score, course.slope, course.change, sorted(names))
    score, slope, change, chosen = best
    if not chosen:
        return []
    signals = tuple(drive.channels[name].signal for name in chosen)
    return [
        Finding(
            "warning",
            "clock",
            signals,
            f"{', '.join(signals)}: a separate clock, {100 * abs(slope):.2f} % "
            f"{'slow' if slope > 0 else 'fast'}: the delay against the other signals changes by "
            f"{change * 1e3:.0f} ms over the run (residual of the balances {100 * now:.0f} %, "
            f"{100 * score:.0f} % when corrected)",
            channels=tuple(chosen),
            windows=(whole_of(drive, chosen[0]),),
            amount=slope,
        )
    ]


def _rest_on_course(tight: list[Relation], names: set[str], course: _Course, grid: Grid) -> float:
    """Rest of the balances with the delay that grows taken off."""
    at = np.arange(len(next(iter(tight[0].terms.values()))), dtype=np.float64)
    delay = course.start * grid.rate_hz + course.slope * at
    return badness([_moved(relation, names, delay).rest() for relation in tight])


def _put_right(tight: list[Relation], names: set[str], course: _Course, grid: Grid) -> bool:
    """Whether a clock of its own explains what neither a delay nor bodies that roll do."""
    delay_s = _best_delay(_liveliest(tight), names, grid.rate_hz)
    late = badness([_shifted_rest(relation, names, delay_s, grid.rate_hz) for relation in tight])
    rolling = badness([relation.rest_of_rolling() for relation in tight])
    return _rest_on_course(tight, names, course, grid) < 0.6 * min(late, rolling)


def _on_one_clock(drive: Drive, names: set[str]) -> list[set[str]]:
    """Each channel alone, and those that come in one message."""
    groups = [{name} for name in sorted(names)]
    for name in sorted(names):
        times = drive.channels[name].time_s
        group = {other for other in names if np.array_equal(drive.channels[other].time_s, times)}
        if len(group) > 1 and group not in groups:
            groups.append(group)
    return groups


@dataclass(frozen=True)
class _Course:
    """Delay of some channels against the others over a run, in s: a line, how far it goes.

    `least` is the change that the scatter about the line makes in one of a thousand runs: with few
    parts it is large, with two there is none.
    """

    delays: FloatArray
    slope: float
    start: float
    change: float
    least: float


def _course_of_delay(
    tight: list[Relation], names: set[str], grid: Grid, parts: int
) -> _Course | None:
    """Line through the delays of the excited parts of a run; none where there are too few."""
    mine = [r for r in tight if r.channels & names and r.channels - names]
    delays, middles = _delays_by_part(mine, names, grid)
    if len(delays) < parts:
        return None
    slope, start = np.polyfit(middles, delays, 1)
    rest = delays - np.polyval([slope, start], middles)
    apart, freedom = middles - middles.mean(), len(delays) - 2
    length = float(middles[-1] - middles[0])
    error = math.sqrt(float(rest @ rest) / max(freedom, 1) / float(apart @ apart))
    least = float(scipy.stats.t.ppf(SURE, max(freedom, 1))) * error * length
    return _Course(delays, float(slope), float(start), abs(float(slope)) * length, least)


def _delays_by_part(
    relations: list[Relation], names: set[str], grid: Grid
) -> tuple[FloatArray, FloatArray]:
    """Delay of the channels in each excited sixth of the grid, and the middles of these in s."""
    delays, middles = [], []
    if not relations:
        return np.zeros(0), np.zeros(0)
    count = len(next(iter(relations[0].terms.values())))
    strong = max(float(np.std(term)) for term in relations[0].terms.values())
    for part in np.array_split(np.arange(count), 6):
        cut = [
            Relation(r.name, {key: term[part] for key, term in r.terms.items()}) for r in relations
        ]
        here = max(float(np.std(term)) for term in cut[0].terms.values())
        if here < 0.3 * strong or len(part) < grid.rate_hz:
            continue
        cut = _liveliest(cut)
        delay_s = _best_delay(cut, names, grid.rate_hz)
        rests = [_shifted_rest(relation, names, delay_s, grid.rate_hz) for relation in cut]
        if max(rests) < 0.4 and abs(delay_s) < 0.95 * LATEST_S:
            delays.append(delay_s)
            middles.append(float(np.mean(part)) / grid.rate_hz)
    return np.array(delays), np.array(middles)


def _liveliest(relations: list[Relation]) -> list[Relation]:
    """The stretch of LIVELIEST samples with most motion, of a long drive."""
    if not relations:
        return relations
    motion = next(iter(relations[0].terms.values())) ** 2
    if len(motion) <= LIVELIEST:
        return relations
    total = np.concatenate([[0.0], np.cumsum(motion)])
    start = int(np.argmax(total[LIVELIEST:] - total[:-LIVELIEST]))
    part = slice(start, start + LIVELIEST)
    return [
        replace(
            r,
            terms={key: term[part] for key, term in r.terms.items()},
            rolling=tuple(term[part] for term in r.rolling),
        )
        for r in relations
    ]


def _shifted_rest(relation: Relation, names: set[str], delay_s: float, rate_hz: float) -> float:
    """Rest of a relation with the channels taken `delay_s` earlier."""
    return _moved(relation, names, delay_s * rate_hz).rest()


def _moved(relation: Relation, names: set[str], samples: float | FloatArray) -> Relation:
    """A relation with the channels taken so many samples earlier."""
    terms = {}
    for channels, term in relation.terms.items():
        if names & set(channels):
            index = np.arange(len(term))
            terms[channels] = np.interp(index + samples, index, term)
        else:
            terms[channels] = term
    return Relation(relation.name, terms)


def _best_delay(relations: list[Relation], names: set[str], rate_hz: float) -> float:
    """Delay within +-`LATEST_S` with the smallest rest, to 1 ms."""
    delays = np.arange(-LATEST_S, LATEST_S + 1e-4, 0.02)
    for width in (0.004, 0.001, 0.0):
        scores = [
            badness([_shifted_rest(relation, names, float(d), rate_hz) for relation in relations])
            for d in delays
        ]
        middle = float(delays[int(np.argmin(scores))])
        delays = middle + width * np.arange(-5, 6)
    return middle
