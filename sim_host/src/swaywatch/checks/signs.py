"""Wrong signs and units: of one channel, of all channels of a kind, or of two or three at once.

A factor at a channel scales its terms in the relations of :mod:`swaywatch.checks.relations`; the
wrong ones are those with which every relation holds. Fewer wrong channels are the better
explanation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from swaywatch.checks.relations import BROKEN, Relation, badness
from swaywatch.checks.samples import Finding
from swaywatch.drive import Drive

FloatArray = npt.NDArray[np.float64]
Change = tuple[tuple[str, float], ...]
"""Channels, and the factor that puts each right."""

GRAVITY = 9.80665
LEFT = 0.35
"""Where several channels are changed at once, a tight relation that they are in may leave so much:
missing physics does, a wrong vehicle more."""
LEAST_SIDE = 0.2
"""Of the larger lateral force of two wheels of an axle, RMS, that the smaller one has."""
TOGETHER = 0.5
"""Correlation from which two wheels of an axle pull the same way."""
SURELY = 0.25
"""A sign or unit is wrong, whatever bodies that roll could explain, where putting it right leaves
no more than this part of what they leave."""

FACTORS: tuple[tuple[float, str], ...] = (
    (-1.0, "its sign is wrong"),
    (180 / math.pi, "it is in rad{per}, not in deg{per}"),
    (math.pi / 180, "it is in deg{per}, not in rad{per}"),
    (GRAVITY, "it is in g (or kg), not in m/s2 (or N)"),
    (1 / GRAVITY, "it is in m/s2 (or N), not in g (or kg)"),
    (3.6, "it is in m/s, not in km/h"),
    (1 / 3.6, "it is in km/h, not in m/s"),
    (1e3, "it is in kilo-units"),
    (1e-3, "it is in milli-units"),
    (1e3 * math.pi / 180, "it is in deg{per}, not in mrad{per}"),
    (1e-3 * 180 / math.pi, "it is in mrad{per}, not in deg{per}"),
    (1e-3 * GRAVITY, "it is in mg, not in m/s2"),
    (1e3 / GRAVITY, "it is in m/s2, not in mg"),
    (0.3048, "it is in ft/s2, not in m/s2"),
)
"""Factor that puts a channel right, and what it means."""
_OF_ACCELERATIONS = (1e-3 * GRAVITY, 1e3 / GRAVITY, 0.3048)


def factor_text(factor: float, name: str) -> str | None:
    """What a factor that puts a channel right means, if it is a known one."""
    text = dict(FACTORS).get(known_factor(factor) or 0.0)
    return None if text is None else text.format(per="/s" if "rate" in name else "")


def known_factor(factor: float) -> float | None:
    """The factor of a wrong sign or unit that is meant."""
    near = (known for known, _ in FACTORS if 0.75 < factor / known < 1.33)
    return next(near, None)


def check_factors(drive: Drive, relations: list[Relation]) -> tuple[float, list[Finding]]:
    """The one channel, else the fewest, whose signs or units explain what does not hold.

    Returns the rest that is left then (inf: nothing explains it) and the findings.
    """
    broken = [relation for relation in relations if relation.is_broken()]
    rolled = [r for r in relations if r.tight and r.rest() > BROKEN and r not in broken]
    if not broken and not rolled:
        return math.inf, []
    axles = _axles(drive)
    candidates: list[tuple[float, str, float]] = []
    suspects = sorted(set().union(*(relation.channels for relation in broken + rolled)))
    for name, (factor, _) in itertools.product(suspects, FACTORS):
        if not fits_quantity(name, factor):
            continue
        if not broken and not _surely(rolled, name, factor):
            continue
        if not _sides_alike(axles, ((name, factor),)):
            continue
        if not any(relation.is_broken(name, factor) for relation in relations):
            rests = [relation.rest(name, factor) for relation in relations]
            candidates.append((badness(rests), name, factor))
    candidates.sort()
    if not candidates:
        return _check_several(drive, relations, broken) if broken else (math.inf, [])
    broken = broken or rolled
    best = candidates[0]
    equal = [c for c in candidates if c[0] < 1.15 * best[0] + 0.02][:4]
    signals = tuple(dict.fromkeys(drive.channels[c[1]].signal for c in equal))
    parts = [
        f"{drive.channels[name].signal}: {factor_text(factor, name)}" for _, name, factor in equal
    ]
    names = "; ".join(relation.name for relation in broken)
    advice = f'correct it in the signals.toml, e.g. {best[1]} = {{ signal = "{signals[0]}", ' + (
        "sign = -1 }" if best[2] == -1.0 else 'unit = "..." }'
    )
    tight = [relation.rest(best[1], best[2]) for relation in relations if relation.tight]
    return badness(tight) if tight else best[0], [
        Finding(
            "error",
            "sign_or_unit",
            signals,
            f"{' - or '.join(parts)}. Does not hold: {names} "
            f"(residual {100 * max(relation.rest() for relation in broken):.0f} %, when corrected "
            f"{100 * max(relation.rest(best[1], best[2]) for relation in broken):.0f} %); {advice}",
            channels=tuple(dict.fromkeys(c[1] for c in equal)),
            windows=(whole_of(drive, best[1]),),
            amount=best[2],
        )
    ]


def _surely(rolled: list[Relation], name: str, factor: float) -> bool:
    """Whether a factor explains far more than bodies that roll do."""
    return all(
        r.rest(name, factor) < SURELY * r.rest_of_rolling() for r in rolled if name in r.channels
    )


@dataclass(frozen=True)
class _Axle:
    """Lateral forces of an axle's left and right wheel: RMS about their means, correlation."""

    sizes: tuple[float, float]
    together: float


def _axles(drive: Drive) -> dict[str, _Axle]:
    """Axles of which both lateral forces are there, by the channels without their last letter."""
    found = {}
    for name, left in drive.channels.items():
        right = drive.channels.get(name[:-1] + "r")
        if "wheel_lateral_force" in name and name.endswith("l") and right is not None:
            forces = left.value, np.interp(left.time_s, right.time_s, right.value)
            one, other = (float(np.std(force)) for force in forces)
            together = float(np.corrcoef(*forces)[0, 1]) if min(one, other) > 0.0 else 0.0
            found[name[:-1]] = _Axle((one, other), together)
    return found


def _sides_alike(axles: Mapping[str, _Axle], change: Change) -> bool:
    """Whether left and right wheel of every axle pull the same way then, about as much.

    What turns the car about its vertical axis (a brake) breaks its balance as a wrong sign of one
    wheel does, but that wheel goes on pulling as the other one.
    """
    factors = dict(change)
    for name in {name[:-1] for name in factors} & axles.keys():
        each = [factors.get(name + side, 1.0) for side in "lr"]
        pair = [abs(f) * size for f, size in zip(each, axles[name].sizes, strict=True)]
        if min(pair) < LEAST_SIDE * max(pair):
            return False
        if each[0] * each[1] * axles[name].together < -TOGETHER * abs(each[0] * each[1]):
            return False
    return True


def fits_quantity(name: str, factor: float) -> bool:
    """Whether a unit error of `factor` can happen to a channel."""
    if factor in (-1.0, 1e3, 1e-3):
        return not (factor == -1.0 and name == "speed")
    if factor in (3.6, 1 / 3.6):
        return name == "speed"
    if factor in _OF_ACCELERATIONS:
        return "acceleration" in name
    if factor in (GRAVITY, 1 / GRAVITY):
        return "acceleration" in name or "force" in name
    return "yaw_rate" in name or "angle" in name or name == "articulation"


def whole_of(drive: Drive, name: str) -> tuple[float, float]:
    """First and last time of a channel."""
    time_s = drive.channels[name].time_s
    return float(time_s[0]), float(time_s[-1])


def _unexplained(
    broken: list[Relation], drive: Drive, either: Sequence[Change] = ()
) -> list[Finding]:
    """Relations that do not hold; `either`: changes that explain them equally well."""
    reason = "no wrong sign or unit of up to three signals explains it"
    if either:
        reason = "it may be that " + "; or that ".join(
            " and ".join(
                f"{drive.channels[name].signal}: {factor_text(factor, name)}"
                for name, factor in change
            )
            for change in either
        )
    findings = []
    for relation in broken:
        signals = tuple(drive.channels[name].signal for name in sorted(relation.channels))
        findings.append(
            Finding(
                "warning",
                "sign_or_unit",
                signals,
                f"does not hold: {relation.name} (residual {100 * relation.rest():.0f} % of its "
                f"largest term), and {reason}; check the "
                "masses and lengths in the vehicle.toml and the positions of the accelerometers",
            )
        )
    return findings


# --- several at once ------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Sums:
    """Products of the terms of a relation: its rest with any factors is a quadratic form."""

    relation: Relation
    gram: FloatArray

    def scaled(self, names: Sequence[str], factors: FloatArray) -> FloatArray:
        """Factor of every term, (changes, terms), from those of the channels, (changes, names)."""
        own = [[names.index(name) for name in channels] for channels in self.relation.terms]
        return np.stack([np.prod(factors[:, columns], axis=1) for columns in own], axis=1)

    def rests(self, scales: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rest with every row of factors, and whether the relation holds then."""
        squares = np.einsum("ht,tu,hu->h", scales, self.gram, scales)
        sizes = np.sort(np.abs(scales) * np.sqrt(np.diag(self.gram)), axis=1)
        rest = np.sqrt(np.maximum(squares, 0.0)) / np.maximum(sizes[:, -1], 1e-12)
        if self.relation.tight:
            changed = np.any(scales != 1.0, axis=1)
            return rest, rest <= np.where(changed, LEFT, BROKEN)
        return rest, (rest <= 1.4) & (sizes[:, -1] <= 2.5 * sizes[:, -2])


def _check_several(
    drive: Drive, relations: list[Relation], broken: list[Relation]
) -> tuple[float, list[Finding]]:
    """The fewest channels whose signs or units together explain every relation."""
    sums = []
    for relation in relations:
        terms = np.stack(list(relation.terms.values()))
        sums.append(_Sums(relation, terms @ terms.T / terms.shape[1]))
    suspects = sorted(set().union(*(relation.channels for relation in relations)))
    single: list[Change] = [
        ((name, factor),)
        for name, (factor, _) in itertools.product(suspects, FACTORS)
        if fits_quantity(name, factor)
    ]
    kinds, axles = _kinds(suspects), _axles(drive)
    for changes in (kinds, _joined([*single, *kinds], 2), _joined(single, 3)):
        best = _explaining(sums, [c for c in changes if _sides_alike(axles, c)])
        if len(best) == 1:
            score, change = best[0]
            return score, _several_wrong(drive, change, sums, broken)
        if best:
            return math.inf, _unexplained(broken, drive, [change for _, change in best])
    return math.inf, _unexplained(broken, drive)


def _kinds(names: Iterable[str]) -> list[Change]:
    """All channels of one quantity have the same wrong sign or unit."""
    found: dict[str, list[str]] = {}
    for name in names:
        for quantity in ("acceleration", "yaw_rate", "force", "wheel_lateral_force"):
            if quantity in name:
                found.setdefault(quantity, []).append(name)
    return [
        tuple((name, factor) for name in members)
        for members in found.values()
        for factor, _ in FACTORS
        if len(members) > 1 and all(fits_quantity(name, factor) for name in members)
    ]


def _joined(changes: Sequence[Change], number: int) -> list[Change]:
    """So many changes of different channels at once."""
    found = []
    for several in itertools.combinations(changes, number):
        names = [name for change in several for name, _ in change]
        if len(set(names)) == len(names):
            found.append(tuple(itertools.chain(*several)))
    return found


def _explaining(sums: Sequence[_Sums], changes: Sequence[Change]) -> list[tuple[float, Change]]:
    """Changes with which all relations hold: the best, and those as good."""
    if not changes:
        return []
    found = [own.rests(own.scaled(*_factors(sums, changes))) for own in sums]
    rests, holds = zip(*found, strict=True)
    scores = np.sqrt(np.mean(np.square(np.minimum(rests, 2.0)), axis=0))
    scores[~np.all(holds, axis=0)] = np.inf
    best = float(np.min(scores))
    if not math.isfinite(best):
        return []
    order = np.argsort(scores)
    return [(float(scores[i]), changes[i]) for i in order if scores[i] < 1.15 * best + 0.02][:4]


def _factors(sums: Sequence[_Sums], changes: Sequence[Change]) -> tuple[list[str], FloatArray]:
    """Channels of all relations, and their factors with every change; (changes, channels)."""
    names = sorted(set().union(*(own.relation.channels for own in sums)))
    factors = np.ones((len(changes), len(names)))
    for row, change in enumerate(changes):
        for name, factor in change:
            factors[row, names.index(name)] = factor
    return names, factors


def _several_wrong(
    drive: Drive, change: Change, sums: Sequence[_Sums], broken: list[Relation]
) -> list[Finding]:
    """One finding for each channel."""
    factors = _factors(sums, [change])
    mine = [own for own in sums if own.relation in broken]
    mine = [own for own in mine if own.relation.tight] or mine
    before = max(own.relation.rest() for own in mine)
    after = max(float(own.rests(own.scaled(*factors))[0][0]) for own in mine)
    findings = []
    for name, factor in change:
        signal = drive.channels[name].signal
        others = [drive.channels[other].signal for other, _ in change if other != name]
        setting = "sign = -1 }" if factor == -1.0 else 'unit = "..." }'
        findings.append(
            Finding(
                "error",
                "sign_or_unit",
                (signal,),
                f"{signal}: {factor_text(factor, name)}, beside {' and '.join(others)}. "
                f"{len(broken)} relations between signals do not hold (residual "
                f"{100 * before:.0f} %, when all are corrected {100 * after:.0f} %); "
                "correct it in the signals.toml, e.g. "
                f'{name} = {{ signal = "{signal}", {setting}',
                channels=(name,),
                windows=(whole_of(drive, name),),
                amount=factor,
            )
        )
    return findings
