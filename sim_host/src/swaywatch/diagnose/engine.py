"""The whole diagnosis: files in, diagnosis.json out."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from swaywatch.checks.sensor_faults import SensorFaults, combined
from swaywatch.diagnose.car_alone.engine import diagnose_car_alone
from swaywatch.diagnose.evidence.baselines import CARES, possible
from swaywatch.diagnose.evidence.drifts import contradicted
from swaywatch.diagnose.evidence.evidence import UNEXPLAINED_ABOVE
from swaywatch.diagnose.evidence.search import Progress, Search, reduced_chi_square
from swaywatch.diagnose.evidence.verdict import Verdict, decide
from swaywatch.diagnose.fit.as_written import as_written
from swaywatch.diagnose.fit.data import Loaded, load
from swaywatch.diagnose.fit.fit import COMPARED, OBSERVER, Fitter, Problem
from swaywatch.diagnose.fit.road_vehicle import on_springs, outside
from swaywatch.diagnose.fit.simulation import attach
from swaywatch.diagnose.fit.stretches import misfit_of
from swaywatch.diagnose.model import embedded, model_block
from swaywatch.diagnose.report.describe import calibrated, describe, too_small
from swaywatch.diagnose.report.page import page, write_page
from swaywatch.diagnose.report.stability import stability
from swaywatch.diagnose.report.unexplained import locate_rest
from swaywatch.discover.find import Discovery, Laws
from swaywatch.discover.nearest import instead, nearest
from swaywatch.discover.report import take_law, with_law
from swaywatch.effects.effect import Effect, library
from swaywatch.errors import RecordingError
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

FORMAT = 3


#: Share of what may be simulated up to which a search is made once more.
AGAIN = 0.5

Made = TypeVar("Made")


class Failures:
    """Parts of a diagnosis that failed, although the verdict stands without them.

    Attributes
    ----------
    sentences
        What failed, and how.
    """

    def __init__(self) -> None:
        self.sentences: list[str] = []

    def part(self, what: str, make: Callable[[], Made], otherwise: Made) -> Made:
        """What is made, or else, if that fails for whatever reason, the other."""
        try:
            return make()
        except Exception as error:  # a verdict that took minutes must not be lost with a part of it
            text = " ".join(str(error).split())[:200]
            self.sentences.append(f"{what} failed ({type(error).__name__}: {text})")
            return otherwise


def _silent(stage: str, share: float) -> None:
    del stage, share


def diagnose(
    recordings: Sequence[Path],
    vehicle: Path,
    signals: Path,
    *,
    simulations: Sequence[Path] = (),
    simulation_signals: Path | None = None,
    extra: Sequence[Effect] = (),
    progress: Progress = _silent,
    report: Path | None = None,
) -> dict[str, Any]:
    """Diagnose runs of one combination against our own model or the user's simulation.

    Parameters
    ----------
    recordings, vehicle, signals
        Files.
    simulations
        The user's own simulation of the runs, or one FMU; none: our own model.
    simulation_signals
        The roles of the simulations, where they are others.
    extra
        Effects beyond those of the library.
    progress
        Called with a stage and the share done.
    report
        Where to write the HTML page.

    Returns
    -------
    dict
        The content of diagnosis.json.
    """
    believed = load_vehicle(vehicle)
    if believed.trailer is None:
        if simulations:
            raise RecordingError(
                f"{vehicle}: no [trailer]: a car alone is compared with our own model only"
            )
        return diagnose_car_alone(recordings, believed, signals, progress, report)
    with threadpool_limits(1):  # small matrices: threads would wait for each other
        found = diagnose_combination(
            recordings, vehicle, signals, (simulations, simulation_signals), extra, progress
        )
    if report is not None and found.verdict is not None:
        found.write_page(found.verdict, report)
    if found.failures.sentences:
        found.result["failed"] = found.failures.sentences
    progress("done", 1.0)
    return found.result


@dataclass(frozen=True)
class Diagnosed:
    """What a diagnosis found.

    Attributes
    ----------
    result
        The content of diagnosis.json.
    verdict
        The fits behind it; None where the recordings cannot be compared with a model.
    vehicle
        As read.
    failures
        Parts that could not be made.
    """

    result: dict[str, Any]
    verdict: Verdict | None
    vehicle: Vehicle
    failures: Failures

    def write_page(self, verdict: Verdict, report: Path) -> None:
        """Write the HTML page; a page that fails costs no verdict."""

        def made() -> None:
            text = page(self.result, verdict, self.vehicle)
            write_page(text, report)

        self.failures.part("the page", made, None)


def diagnose_combination(
    recordings: Sequence[Path],
    vehicle: Path,
    signals: Path,
    simulated: tuple[Sequence[Path], Path | None] = ((), None),
    extra: Sequence[Effect] = (),
    progress: Progress = _silent,
) -> Diagnosed:
    """`diagnose` of a car with a trailer, without its page; `simulated`: files and their roles."""
    simulations, simulation_signals = simulated
    failures = Failures()
    loaded = load(recordings, vehicle, signals, whole=bool(simulations))
    if loaded.problem is None:
        return Diagnosed(_cannot(loaded), None, loaded.vehicle, failures)
    effects = library(extra)
    if simulations:
        _, problem, notes = attach(
            loaded.problem, simulations, signals, simulation_signals=simulation_signals
        )
        loaded.checks += notes
        verdict, law, _ = _searched(problem, effects, progress, failures, own=False)
    else:
        files = recordings, vehicle, signals
        loaded, verdict, law = _with_and_without_drifts(loaded, files, effects, progress, failures)
    loaded.problem = verdict.problem
    _say_what_is_left(loaded, verdict, failures)
    loaded.checks += verdict.problem.budget.sentences()
    verdict.written = failures.part(
        "the simulation with vehicle.toml as written", lambda: as_written(verdict.problem), None
    )
    result = _result(loaded, verdict, effects)
    if loaded.stretches is not None and not loaded.stretches.whole:
        result["stretches"] = loaded.stretches.entries()
    take_law(result, law)
    whole = verdict.problem
    costs = failures.part(
        "what each finding costs", lambda: stability(whole, verdict.fit, verdict.noise), None
    )
    if costs is not None:
        result["stability"] = costs
    result["signals"] = embedded(signals)
    result["inputs"] = {
        "recordings": [str(path) for path in recordings],
        "vehicle": str(vehicle),
        "signals": str(signals),
    }
    return Diagnosed(result, verdict, loaded.vehicle, failures)


def _with_and_without_drifts(
    loaded: Loaded,
    files: tuple[Sequence[Path], Path, Path],
    effects: list[Effect],
    progress: Progress,
    failures: Failures,
) -> tuple[Loaded, Verdict, Discovery | None]:
    """What is found beside our own model; once more where a drift that was taken off was none."""
    assert loaded.problem is not None
    budget = loaded.problem.budget
    verdict, law, right = _searched_and_checked(effects, progress, failures, loaded)
    if not right or budget.refuses("the recording without drifts taken off", AGAIN):
        return loaded, verdict, law
    again = load(*files, right=right)
    if again.problem is None:
        return loaded, verdict, law
    again.problem = replace(again.problem, budget=budget)
    verdict, law, _ = _searched_and_checked(effects, progress, failures, again)
    return again, verdict, law


def _take_mass_or_loads(loaded: Loaded, effects: Sequence[Effect]) -> None:
    """Of loads that do not fit the masses of the file one is wrong: what the recording says of it.

    Each is one mistake in the file, so that the calibrated vehicle that leaves less is likelier.
    """
    problem, loads = loaded.problem, loaded.weighed
    if problem is None or loads is None or loads.otherwise is None:
        return
    beliefs, sentence = loads.otherwise
    other = replace(problem, beliefs=beliefs)
    if _misfit(other, effects) < _misfit(problem, effects):
        loaded.problem = other
        loaded.checks = [sentence if text in loads.wrong else text for text in loaded.checks]


def _misfit(problem: Problem, effects: Sequence[Effect]) -> float:
    """What the calibrated rigid vehicle leaves; infinite where it diverges."""
    try:
        return Search(problem, effects, _silent).baseline().fit.chi2
    except RecordingError:
        return math.inf


def _say_what_is_left(loaded: Loaded, verdict: Verdict, failures: Failures) -> None:
    """Notes on the misfit that remains, and on stretches that contradict the verdict."""
    if reduced_chi_square(verdict.fit) > UNEXPLAINED_ABOVE:
        watched = Fitter(replace(verdict.problem, observer=OBSERVER))
        rest = failures.part(
            "where the rest acts", lambda: locate_rest(watched, verdict.fit), verdict.notes
        )
        verdict.notes = [*verdict.near, *rest]
    if loaded.stretches is not None:
        bad = loaded.stretches.contradictions(reduced_chi_square(verdict.fit))
        verdict.notes = [*verdict.notes, *({"reason": text} for text in bad)]
        if bad and verdict.word == "consistent":
            verdict.word = "unexplained"


#: A verdict, its law, and the channels that it shows to have had no drift.
Searched = tuple[Verdict, Discovery | None, frozenset[tuple[str, str]]]


def _searched(
    problem: Problem,
    effects: list[Effect],
    progress: Progress,
    failures: Failures,
    *,
    own: bool,
    faults: SensorFaults | None = None,
) -> Searched:
    """Verdict and law of a problem; `own`: compared with our own model."""
    cares = CARES if own else CARES[:1]
    planar = [Search(cared(problem, care), effects, progress) for care in cares]
    if not own:
        return decide(planar, None, progress), None, frozenset()
    springs = possible(Search(on_springs(problem), outside(effects), progress))
    laws = Laws((planar[0], springs))
    for search in (*planar, springs):
        search.beyond = laws.alone

    def discovered() -> Discovery | None:
        return failures.part(
            "the search for laws", lambda: laws.discover(verdict.paths, progress), None
        )

    verdict = decide(planar, springs, progress)
    law = discovered()
    right = _without_drift(verdict, laws, faults)
    needs_more = (law is None or len(law.fit.terms) > 1) and not right
    needs_more &= any(search.ended_by_law for search in (*planar, springs))
    if needs_more and not problem.budget.refuses("effects in place of a law", AGAIN):
        # for a law that does not explain it alone after all: the library goes as deep as without
        for search in (*planar, springs):
            search.beyond = None
        verdict = decide(planar, springs, progress)
        law = discovered()
    if law is None:
        verdict.near = nearest(laws.tried(), verdict.fit)
        verdict.remarks = instead(laws.tried(), verdict.fit)
    return (verdict if law is None else with_law(verdict, law)), law, right


def _without_drift(
    verdict: Verdict, laws: Laws, faults: SensorFaults | None
) -> frozenset[tuple[str, str]]:
    """Channels that had no drift, as the verdict or the best law shows them."""
    if faults is None:
        return frozenset()
    right = contradicted(Fitter(verdict.problem), verdict.fit, faults.found)
    alone = laws.tried_alone()
    return right | (contradicted(alone[0].judge, alone[1], faults.found) if alone else frozenset())


def _searched_and_checked(
    effects: list[Effect], progress: Progress, failures: Failures, loaded: Loaded
) -> Searched:
    """The same; of a long recording with the stretches that do not fit searched once more."""
    _take_mass_or_loads(loaded, effects)
    problem = loaded.problem
    assert problem is not None
    found = _searched(problem, effects, progress, failures, own=True, faults=loaded.faults)
    stretches = loaded.stretches
    if stretches is None or stretches.whole:
        return found
    stretches.misfit = misfit_of(found[0].problem, found[0].fit, stretches.others)
    apart = stretches.apart(reduced_chi_square(found[0].fit))
    if apart and not problem.budget.refuses("stretches that do not fit", AGAIN):
        stretches = stretches.with_worst(reduced_chi_square(found[0].fit))
        again = replace(problem, runs=tuple(stretches.searched))
        found = _searched(again, effects, progress, failures, own=True, faults=loaded.faults)
        stretches.misfit = misfit_of(found[0].problem, found[0].fit, stretches.others)
        loaded.stretches = stretches
    loaded.checks.append(stretches.summary(reduced_chi_square(found[0].fit)))
    return found


def cared(problem: Problem, care: float) -> Problem:
    """The problem with the tolerances of the vehicle's file times `care`."""
    return replace(problem, beliefs=replace(problem.beliefs, care=care))


def _cannot(loaded: Loaded) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "verdict": "unexplained",
        "effects": loaded.faults.entries(loaded.signals),
        "unexplained": [{"reason": text} for text in loaded.cannot],
        "model": {},
        "checks": [*loaded.checks, *loaded.cannot],
    }


def _untestable(problem: Problem, effects: Sequence[Effect]) -> list[str]:
    """Explanations that the recorded channels cannot test, in sentences."""
    missing = [c for c in COMPARED if any(c not in run.channels for run in problem.runs)]
    found = []
    if any(c.startswith("wheel_vertical_load") for c in missing):
        found.append(
            "without wheel loads axle_load_harmonic and tyre_stiffness_change differ only "
            "in their course in time, and load transfer is assumed"
        )
    if any(c.startswith("wheel_lateral_force") for c in missing):
        found.append("without wheel forces axles are distinguished only by the motion")
    if "hitch_lateral_force" in missing:
        found.append(
            "without the hitch force trailer mass and trailer forces are harder to distinguish"
        )
    for e in effects:
        if e.component in missing and e.kind == "measurement":
            found.append(f"{e.id} of {e.component}: not recorded")
    return found


def _unseen(verdict: Verdict) -> list[str]:
    """A sentence on what a recording without mismatch cannot exclude."""
    largest: dict[str, float] = {}
    for row in verdict.hidden:
        if row["parameter"] == "factor" and row["up_to"] > 0.1:
            name = f"{row['id']} of {row['component']}"
            largest[name] = max(largest.get(name, 0.0), 100.0 * row["up_to"])
    if not largest:
        return []
    names = ", ".join(f"{name} by less than {size:.0f} %" for name, size in largest.items())
    return [f"this recording cannot exclude {names}"]


def _result(loaded: Loaded, verdict: Verdict, effects: Sequence[Effect]) -> dict[str, Any]:
    problem = loaded.problem
    assert problem is not None
    effects_found = describe(verdict, problem, loaded.signals)
    faults = loaded.faults.entries(loaded.signals)
    result: dict[str, Any] = {
        "format": FORMAT,
        "verdict": combined(verdict.word, faults),
        "effects": [*effects_found, *faults],
        "calibrated": calibrated(verdict, problem),
        "unexplained": verdict.notes,
        "model": model_block(problem, verdict.fit, verdict.baseline, verdict.written),
        "checks": [
            *loaded.checks,
            *loaded.cannot,
            *_untestable(problem, effects),
            *_unseen(verdict),
            *too_small(verdict),
            *verdict.remarks,
        ],
        "evidence": {
            "reduced_chi_square_as_written": (
                None if verdict.written is None else reduced_chi_square(verdict.written)
            ),
            "reduced_chi_square_calibrated": reduced_chi_square(verdict.baseline),
            "reduced_chi_square_diagnosed": reduced_chi_square(verdict.fit),
            "log_bayes_factor": verdict.evidence,
            "independent_sample": verdict.noise,
            "tolerances_of_the_file_times": verdict.problem.beliefs.care,
            "could_be_hidden": verdict.hidden,
            "simulated_s": round(problem.budget.spent_s, 1),
            "ranking": [{"name": n, "log_bayes_factor": v} for n, v in verdict.candidates],
        },
    }
    return result


def write(result: dict[str, Any], path: Path) -> None:
    """Write JSON whole or not at all; a number that is none becomes null."""
    text = json.dumps(_finite(result), indent=1, default=_plain, allow_nan=False)
    part = path.with_suffix(".part")
    part.write_text(text + "\n")
    part.replace(path)


def _finite(value: Any) -> Any:
    """The same with null for what is not a number or infinite: JSON knows neither."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_finite(item) for item in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    return str(value)
