"""The work of a survey: each run analysed and diagnosed in processes of their own.

A run that cannot be read, crashes or takes too long costs only itself. What is done is written at
once, and kept when the survey is started again. Who does the work, threads of this process or the
workers of a cluster, is the executor's affair (:mod:`swaywatch.survey.workers`).
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Executor, Future, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from swaywatch.diagnose.report.labels import named, part, when
from swaywatch.diagnose.report.sentences import sentence
from swaywatch.errors import SwaywatchError
from swaywatch.recording.guard import must_exist
from swaywatch.survey.outcome import Journal, SurveyOutcome
from swaywatch.survey.plan import SurveyRun, groups
from swaywatch.survey.warm import Ran, Warm

DIAGNOSED = ("all", "outliers", "none")
"""Which runs a survey diagnoses."""
TOGETHER_MOST = 4
"""Runs that are diagnosed together at most: those that disagree most."""


@dataclass(frozen=True)
class Order:
    """What a worker is asked for beside the run.

    Attributes
    ----------
    out : folder of the results
    limit_s : of one analysis or diagnosis
    whole : diagnosis and pages too, not only the analysis
    """

    out: Path
    limit_s: float
    whole: bool


def survey(
    runs: Sequence[SurveyRun],
    out: Path,
    executor: Executor,
    *,
    diagnose: str = "all",
    limit_s: float,
    report: Callable[[SurveyOutcome], None] = lambda outcome: None,
) -> tuple[list[SurveyOutcome], list[SurveyOutcome]]:
    """Survey runs.

    Parameters
    ----------
    runs : from :func:`swaywatch.survey.plan.find_runs`
    out : folder of the results
    executor : runs functions of this module, here or on other machines that have the same files
    diagnose : one of :data:`DIAGNOSED`; ``outliers``: those that are unlike the others
    limit_s : of one analysis or diagnosis
    report : called with each outcome as it comes

    Returns
    -------
    alone, together : outcomes of the runs, in their order, and of combinations of which several
        runs disagree, diagnosed together
    """
    from swaywatch.survey.fleet import mark  # not in the workers, which need neither
    from swaywatch.survey.table import write_table

    journal = Journal(out)
    done: dict[str, SurveyOutcome] = {}

    def all_of(left: dict[Future[SurveyOutcome], str]) -> list[SurveyOutcome]:
        """Take outcomes as they come; only this thread writes them down."""
        for future in as_completed(left):
            name = left[future]
            try:
                outcome = future.result()
            except CancelledError:
                raise SwaywatchError(
                    "the workers are gone; started again, the survey resumes where it stopped"
                ) from None
            except Exception as error:
                outcome = _broken(name, error)
            done[name] = outcome
            if outcome is not journal.kept.get(name):
                journal.add(outcome)
            report(outcome)
        return [done[name] for name in left.values()]

    def each(of: Sequence[SurveyRun], whole: bool) -> None:
        order, kept = Order(out, limit_s, whole), journal.kept
        all_of({executor.submit(one, run, order, kept.get(run.name)): run.name for run in of})

    each(runs, diagnose == "all")
    mark([done[run.name] for run in runs])
    if diagnose == "outliers":
        each([run for run in runs if done[run.name].stands_out], True)
        mark([done[run.name] for run in runs])
    several = [
        members
        for group in groups(runs).values()
        if len(members := _worst([(r, done[r.name]) for r in group])) > 1
    ]
    order = Order(out, limit_s, True)
    together = all_of(
        {
            executor.submit(several_of, m, order, journal.kept.get(_together(m))): _together(m)
            for m in several
        }
    )
    alone = [done[run.name] for run in runs]
    journal.write([*alone, *together])
    write_table(out / "survey.parquet", alone)
    return alone, together


def _broken(name: str, error: Exception) -> SurveyOutcome:
    """What is said of a run that vanished, cannot be read, or made the survey itself stumble."""
    if isinstance(error, OSError):
        text = f"{error.filename or name}: cannot be read: {error.strerror or error}"
    elif isinstance(error, SwaywatchError):
        text = str(error)
    elif type(error).__name__ == "KilledWorker":
        text = "every worker that tried it died: too little memory there, most likely"
    else:
        text = f"its results cannot be read ({type(error).__name__}: {error})"
    return SurveyOutcome(name, "", why=[text])


def _together(members: Sequence[SurveyRun]) -> str:
    return " + ".join(run.name for run in members)


def _worst(members: list[tuple[SurveyRun, SurveyOutcome]]) -> list[SurveyRun]:
    out = [(r, o) for r, o in members if o.state == "disagrees"]
    out.sort(key=lambda pair: -(pair[1].mismatch or 0.0))
    return sorted((r for r, _ in out[:TOGETHER_MOST]), key=lambda run: run.name)


def one(run: SurveyRun, order: Order, kept: SurveyOutcome | None) -> SurveyOutcome:
    """Analyse one run, and diagnose it where that is ordered; `kept` where nothing has changed."""
    must_exist(run.recording)
    outcome = SurveyOutcome(run.name, run.key(), whole=order.whole, vehicle=str(run.vehicle or ""))
    if run.vehicle is None or run.signals is None:
        lacking = "vehicle.toml" if run.vehicle is None else "signals.toml"
        outcome.why.append(
            f"no {lacking} beside it or above it; give one with --{lacking.partition('.')[0]}"
        )
        return outcome
    if kept is not None and kept.key == outcome.key and kept.whole >= order.whole:
        return kept
    place = order.out / run.place
    common = ["--vehicle", str(run.vehicle), "--signals", str(run.signals)]
    words = ["analyze", str(run.recording), *common, "--separate"]
    problem = _noted(outcome, _command(
        words if order.whole else [*words, "--no-report"], place, order.limit_s
    ))  # fmt: skip
    if not problem:
        _read_analysis(outcome, place, run.place)
    if not order.whole:
        outcome.state = "failed" if problem else "not diagnosed"
        outcome.why += [problem] if problem else []
        return outcome
    # the diagnosis may still correct signals that allow no analysis, and reports it
    words = ["diagnose", str(run.recording), *common]
    second = _noted(outcome, _command(words, place / "diagnosis", order.limit_s))
    _read_diagnosis(outcome, place / "diagnosis", f"{run.place}/diagnosis", second)
    if problem and problem != second:
        outcome.why.append(f"no margin: {problem}")
    return outcome


def several_of(members: list[SurveyRun], order: Order, kept: SurveyOutcome | None) -> SurveyOutcome:
    """Diagnose several runs of a combination together."""
    name = _together(members)
    outcome = SurveyOutcome(name, "".join(run.key()[:16] for run in members))
    if kept is not None and kept.key == outcome.key:
        return kept
    folder = Path(members[0].place).parent
    place = folder / ("together_" + "_".join(Path(run.place).name for run in members))
    command = [
        "diagnose", *(str(run.recording) for run in members),
        "--vehicle", str(members[0].vehicle), "--signals", str(members[0].signals),
    ]  # fmt: skip
    problem = _noted(outcome, _command(command, order.out / place, order.limit_s))
    _read_diagnosis(outcome, order.out / place, place.as_posix(), problem)
    return outcome


_mine = threading.local()


def _command(words: list[str], place: Path, limit_s: float) -> Ran:
    """Run ``swaywatch`` with --out `place`, in this thread's own warm process."""
    if not hasattr(_mine, "warm"):
        _mine.warm = Warm()
    try:
        ran: Ran = _mine.warm.run([*words, "--out", str(place)], limit_s)
    except OSError as error:
        text = error.strerror or str(error)
        return Ran(1, f"{words[0]} could not be done: {text}")
    if ran.late:
        return replace(
            ran, said=f"{words[0]} took longer than {limit_s:.0f} s; --limit allows more"
        )
    if ran.code in (0, 3):  # 3: the logger lost frames, which the analysis says too
        return replace(ran, said="")
    said = [line.strip() for line in ran.said.strip().splitlines() if line.strip()]
    name = f"swaywatch {words[0]}: "
    at = max((i for i, line in enumerate(said) if line.startswith(name)), default=len(said) - 1)
    text = " ".join(said[max(at, 0) :]).removeprefix(name)
    return replace(ran, said=text or f"{words[0]} ended with exit code {ran.code}")


def _noted(outcome: SurveyOutcome, ran: Ran) -> str:
    """Cost of a command put to its run; what went wrong, or nothing."""
    outcome.cpu_s = round(outcome.cpu_s + ran.cpu_s, 3)
    outcome.memory_mb = max(outcome.memory_mb, ran.memory_mb)
    return ran.said


def _read_analysis(outcome: SurveyOutcome, place: Path, link: str) -> None:
    drive = json.loads((place / "summary.json").read_text())["drives"][0]
    outcome.conclusion = next(iter(drive["conclusion"]), "")
    critical = drive["values"].get("v_crit_m_s")
    if critical is not None:
        outcome.v_crit_kmh = critical["value"] * 3.6
        outcome.v_crit_se_kmh = critical["standard_error"] * 3.6
    outcome.values = {
        name: [entry["value"], entry["standard_error"], entry.get("believed")]
        for name, entry in drive["values"].items()
    }
    outcome.duration_s = drive["duration_s"]
    order = ("normal", "notice", "warning", "critical")
    states = [alarm["state"] for alarm in drive["alarms"]]
    outcome.alarm = max(states, key=lambda s: order.index(s) if s in order else -1, default="")
    if outcome.whole:
        outcome.pages["margin"] = f"{link}/report.html"


def _read_diagnosis(outcome: SurveyOutcome, place: Path, link: str, problem: str) -> None:
    if problem:
        outcome.state = "failed"
        outcome.why.append(problem)
        return
    found: dict[str, Any] = json.loads((place / "diagnosis.json").read_text())
    outcome.verdict = found["verdict"]
    if (place / "report.html").is_file():
        outcome.pages["diagnosis"] = f"{link}/report.html"
    evidence = found.get("evidence", {})
    outcome.mismatch = evidence.get("reduced_chi_square_calibrated")
    outcome.mismatch_after = evidence.get("reduced_chi_square_diagnosed")
    outcome.effects = [named(f"{e['id']}:{e['component']}") for e in found["effects"]]
    outcome.where = [_where(effect) for effect in found["effects"]]
    outcome.why = [_why(effect, found.get("stability") or {}) for effect in found["effects"]]
    outcome.why += [str(note.get("reason", "")) for note in found["unexplained"]]
    if not found["model"]:
        outcome.state = "cannot say"
    else:
        outcome.state = "agrees" if found["verdict"] == "consistent" else "disagrees"


def _where(effect: dict[str, Any]) -> str:
    spans = when(effect["window_details"], "run 1") or "throughout"
    lines = ", ".join(effect["lines"])
    return f"{part(effect['component'])}: {spans}" + (f", at {lines}" if lines else "")


def _why(effect: dict[str, Any], stability: dict[str, Any]) -> str:
    words = sentence(effect, stability).removesuffix(".")
    if "run 2" not in words:
        words = words.replace("(run 1: ", "(")
    text = f"{words}; confidence {effect['confidence']:.0%}"
    if effect["equivalent"]:
        others = ", ".join(name.replace("_", " ") for name in effect["equivalent"])
        text += f"; cannot be distinguished from {others}"
    return text
