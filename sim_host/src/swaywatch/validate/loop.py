"""The loop of Fig. 5-1: simulate, compare, correct, until every line is within 5 %."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from swaywatch.analysis import DriveResult, analyze, conclude, usable
from swaywatch.cosim import is_fmu
from swaywatch.drive import Drive
from swaywatch.ecu.core import analyze_drive
from swaywatch.errors import RecordingError
from swaywatch.validate.compare import CRITERION, ComparedLine, compare
from swaywatch.validate.correct import (
    RELAXATION,
    Correction,
    OperatingPoint,
    corrected,
    corrections,
    lags,
    physics_of,
)
from swaywatch.validate.fmu_twin import twin_of
from swaywatch.validate.twin import simulate_twin
from swaywatch.vehicle import Vehicle

ROUNDS = 6
Progress = Callable[[str, float, float], None]


@dataclass(frozen=True)
class Round:
    """One turn of the loop.

    Attributes
    ----------
    vehicle
        That was simulated.
    lengths
        Relaxation lengths (m) that were simulated with it, by axle.
    simulations
        One for each drive.
    lines
        The comparison of each drive.
    corrections
        What this comparison corrects.
    """

    vehicle: Vehicle
    lengths: dict[str, float]
    simulations: list[DriveResult]
    lines: list[list[ComparedLine]]
    corrections: list[Correction]

    @property
    def failed(self) -> list[tuple[int, ComparedLine]]:
        """Lines beyond the criterion, with the number of their drive."""
        return [
            (index, line)
            for index, lines in enumerate(self.lines)
            for line in lines
            if not line.passed
        ]

    @property
    def worst(self) -> float:
        """Largest difference as a multiple of what the criterion allows; 0 without lines."""
        return max(
            (abs(x.difference) / x.allowed for xs in self.lines for x in xs if x.allowed > 0.0),
            default=0.0,
        )


@dataclass
class Validation:
    """Everything a validation found.

    Attributes
    ----------
    recordings
        Analysed with the user's vehicle.
    rounds
        In order; the last one is what counts.
    own
        Whether the simulation is ours (and can be corrected and run again).
    """

    recordings: list[DriveResult]
    rounds: list[Round] = field(default_factory=list)
    own: bool = True

    @property
    def passed(self) -> bool:
        """Whether every line of the last round is within the criterion."""
        return bool(self.rounds) and not self.rounds[-1].failed

    @property
    def total(self) -> list[Correction]:
        """Corrections from the first vehicle to the last one."""
        if not self.rounds:
            return []
        found: dict[str, Correction] = {}
        turns = self.rounds if not self.own else self.rounds[:-1]
        for turn in turns:
            for change in turn.corrections:
                first = found.get(change.key)
                before = change.before if first is None else first.before
                found[change.key] = Correction(change.key, before, change.after, change.error)
        return list(found.values())


def validate(
    recordings: Sequence[Path],
    vehicle_path: Path,
    signals_path: Path,
    *,
    simulations: Sequence[Path] = (),
    simulation_signals: Path | None = None,
    rounds: int = ROUNDS,
    strict: bool = True,
    progress: Progress | None = None,
) -> Validation:
    """Compare recordings with simulations of the same drives, and correct our own.

    Parameters
    ----------
    recordings, vehicle_path, signals_path
        As for an analysis.
    simulations
        The user's own, one for each recording in the same order, on the same clock, or one FMU,
        which is driven with the recorded steering and speed, as our plant is without them.
    simulation_signals
        Their signals.toml, where it is another one (`cosim.mapping` for an FMU).
    rounds
        Most turns of the loop.
    strict
        Refuse recordings in which a sign, a unit or a clock is wrong.
    progress
        Called with what is done, how far, and of how much.

    Raises
    ------
    SwaywatchError
        The input is at fault.
    """

    def tell(what: str, done: float, total: float) -> None:
        if progress:
            progress(what, done, total)

    results = analyze(
        recordings, vehicle_path, signals_path, join=False, strict=strict, progress=progress
    )
    vehicle = results[0].vehicle
    if simulations:
        if len(simulations) == 1 and is_fmu(simulations[0]):
            tell("driving the FMU", 0.0, 1.0)
            theirs = [
                _again(twin_of(r.drive, simulations[0], simulation_signals), vehicle)
                for r in results
            ]
        else:
            theirs = analyze(
                simulations, vehicle_path, simulation_signals or signals_path,
                join=False, strict=False, progress=progress,
            )  # fmt: skip
        if len(theirs) != len(results):
            raise RecordingError(
                f"{len(results)} recordings and {len(theirs)} simulations; expected one "
                "simulation for each recording, in the same order"
            )
        found = Validation(results, own=False)
        lines = [compare(a, b) for a, b in zip(results, theirs, strict=True)]
        found.rounds.append(
            Round(vehicle, {}, theirs, lines, _changes(vehicle, {}, lines, results))
        )
        return found
    found = Validation(results)
    lengths: dict[str, float] = {}
    for turn in range(rounds):
        tell(f"simulating, round {turn + 1}", turn, rounds)
        twins = [_simulated(result.drive, vehicle, lengths) for result in results]
        lines = [compare(a, b) for a, b in zip(results, twins, strict=True)]
        changes = _changes(vehicle, lengths, lines, results)
        found.rounds.append(Round(vehicle, dict(lengths), twins, lines, changes))
        if not changes:
            break
        vehicle = corrected(vehicle, changes)
        lengths = lengths | {
            change.key.partition(".")[0]: change.after
            for change in changes
            if change.key.endswith(RELAXATION)
        }
        results = [_again(result.drive, vehicle) for result in results]
        found.recordings = results
    tell("simulating", 1.0, 1.0)
    return found


def _changes(
    vehicle: Vehicle,
    lengths: dict[str, float],
    lines: list[list[ComparedLine]],
    results: list[DriveResult],
) -> list[Correction]:
    """Values of the vehicle first; lags once those are right, for a wrong one bends arguments."""
    values = corrections(vehicle, lines)
    if any(abs(change.share) > CRITERION for change in values):
        return values
    return values + lags(lengths, lines, [_motion(result) for result in results])


def _motion(result: DriveResult) -> OperatingPoint:
    estimates = result.estimates
    good = usable(estimates)
    if not good.any():
        good = estimates.has("line")
    if not good.any():
        return OperatingPoint(1.0, 1.0)  # nothing was compared
    return OperatingPoint(
        float(np.mean(estimates["speed_m_s"][good])),
        2.0 * np.pi * float(np.mean(estimates["frequency_hz"][good])),
    )


def _simulated(drive: Drive, vehicle: Vehicle, lengths: dict[str, float]) -> DriveResult:
    return _again(simulate_twin(drive, vehicle, physics_of(lengths)), vehicle)


def _again(drive: Drive, vehicle: Vehicle) -> DriveResult:
    """Through the core once more, with what is now believed of the vehicle."""
    return conclude(drive, vehicle, analyze_drive(drive, vehicle), [])
