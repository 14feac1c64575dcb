"""The work of a survey: each run analysed and diagnosed in processes of their own.

A run that cannot be read, crashes or takes too long costs only itself. What is done is written at
once, and kept when the survey is started again.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from swaywatch.diagnose.words import how_much, named, part, when
from swaywatch.errors import SwaywatchError
from swaywatch.recording.guard import must_exist, whole_file
from swaywatch.survey.plan import Run, groups

STATES = ("disagrees", "agrees", "cannot say", "failed")
"""What a survey says of a run, the urgent first."""
TOGETHER_MOST = 4
"""Runs that are diagnosed together at most: those that disagree most."""


@dataclass
class Outcome:
    """What a survey found on a run, or on several runs together.

    Attributes
    ----------
    state : one of :data:`STATES`
    verdict : of the diagnosis
    mismatch : rest of the fit of the model, in its noise; about 1 where nothing is missing
    why : sentences: the effects, or what stood in the way
    where : windows and lines of each effect
    v_crit_kmh, v_crit_se_kmh, speed_kmh : of the analysis
    alarm : the highest state
    pages : what there is to open: title -> path below the survey's folder
    """

    name: str
    key: str
    state: str = "failed"
    verdict: str = ""
    mismatch: float | None = None
    mismatch_after: float | None = None
    why: list[str] = field(default_factory=list)
    where: list[str] = field(default_factory=list)
    effects: list[str] = field(default_factory=list)
    v_crit_kmh: float | None = None
    v_crit_se_kmh: float | None = None
    conclusion: str = ""
    alarm: str = ""
    pages: dict[str, str] = field(default_factory=dict)

    def line(self) -> str:
        """What was found in one line: what and where, when, how much."""
        count = len(self.effects)
        found = [
            f"{what} [{where}]" if where else what
            for what, where in zip(self.why[:count], self.where, strict=False)
        ]
        return "; ".join([*found, *self.why[len(found) :]])


def survey(
    runs: Sequence[Run],
    out: Path,
    *,
    jobs: int,
    limit_s: float,
    told: Callable[[Outcome], None] = lambda outcome: None,
) -> tuple[list[Outcome], list[Outcome]]:
    """Survey runs.

    Parameters
    ----------
    runs : from :func:`swaywatch.survey.plan.find_runs`
    out : folder of the results
    jobs : processes at a time
    limit_s : of one analysis or diagnosis
    told : called with each outcome as it comes

    Returns
    -------
    alone, together : outcomes of the runs, in their order, and of combinations of which several
        runs disagree, diagnosed together
    """
    kept = _kept(out)
    done: dict[str, Outcome] = {}

    def all_of(jobs_left: dict[Future[Outcome], str]) -> list[Outcome]:
        """Take outcomes as they come; only this thread writes them down."""
        for future in as_completed(jobs_left):
            name = jobs_left[future]
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            outcome = future.result() if error is None else _broken(name, error)
            done[name] = outcome
            _write(out, [*done.values(), *(o for n, o in kept.items() if n not in done)])
            told(outcome)
        return [done[name] for name in jobs_left.values()]

    with ThreadPoolExecutor(jobs) as pool:
        try:
            alone = all_of({pool.submit(_one, r, out, limit_s, kept): r.name for r in runs})
            several = [
                members
                for group in groups(runs).values()
                if len(members := _worst([(r, done[r.name]) for r in group])) > 1
            ]
            together = all_of(
                {pool.submit(_several, m, out, limit_s, kept): _together(m) for m in several}
            )
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    _write(out, [*alone, *together])
    return alone, together


def _broken(name: str, error: Exception) -> Outcome:
    """What is said of a run that vanished, cannot be read, or made the survey itself stumble."""
    if isinstance(error, OSError):
        text = f"{error.filename or name}: cannot be read: {error.strerror or error}"
    elif isinstance(error, SwaywatchError):
        text = str(error)
    else:
        text = f"its results cannot be read ({type(error).__name__}: {error})"
    return Outcome(name, "", why=[text])


def _together(members: Sequence[Run]) -> str:
    return " + ".join(run.name for run in members)


def _worst(members: list[tuple[Run, Outcome]]) -> list[Run]:
    out = [(r, o) for r, o in members if o.state == "disagrees"]
    out.sort(key=lambda pair: -(pair[1].mismatch or 0.0))
    return sorted((r for r, _ in out[:TOGETHER_MOST]), key=lambda run: run.name)


def _one(run: Run, out: Path, limit_s: float, kept: dict[str, Outcome]) -> Outcome:
    must_exist(run.recording)
    outcome = Outcome(run.name, run.key())
    if run.vehicle is None or run.signals is None:
        lacking = "vehicle.toml" if run.vehicle is None else "signals.toml"
        outcome.why.append(
            f"no {lacking} beside it or above it; give one with --{lacking.partition('.')[0]}"
        )
        return outcome
    if run.name in kept and kept[run.name].key == outcome.key:
        return kept[run.name]
    place = out / run.place
    common = ["--vehicle", str(run.vehicle), "--signals", str(run.signals)]
    problem = _command(["analyze", str(run.recording), *common, "--separate"], place, limit_s)
    if not problem:
        _read_analysis(outcome, place, run.place)
    # signals that allow no analysis may still be put right by the diagnosis, which says so
    second = _command(["diagnose", str(run.recording), *common], place / "diagnosis", limit_s)
    _read_diagnosis(outcome, place / "diagnosis", f"{run.place}/diagnosis", second)
    if problem and problem != second:
        outcome.why.append(f"no margin: {problem}")
    return outcome


def _several(members: list[Run], out: Path, limit_s: float, kept: dict[str, Outcome]) -> Outcome:
    name = _together(members)
    outcome = Outcome(name, "".join(run.key()[:16] for run in members))
    if name in kept and kept[name].key == outcome.key:
        return kept[name]
    folder = Path(members[0].place).parent
    place = folder / ("together_" + "_".join(Path(run.place).name for run in members))
    command = [
        "diagnose", *(str(run.recording) for run in members),
        "--vehicle", str(members[0].vehicle), "--signals", str(members[0].signals),
    ]  # fmt: skip
    problem = _command(command, out / place, limit_s)
    _read_diagnosis(outcome, out / place, place.as_posix(), problem)
    return outcome


def _command(words: list[str], place: Path, limit_s: float) -> str:
    """Run ``swaywatch`` with --out `place`; what went wrong, or nothing."""
    # -P: a plotly.py in the folder of recordings is no module of ours
    command = [sys.executable, "-P", "-m", "swaywatch.cli", *words, "--out", str(place)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=limit_s, check=False,
            stdin=subprocess.DEVNULL, errors="replace",
        )  # fmt: skip
    except OSError as error:
        return f"{words[0]} could not be started: {error.strerror or error}"
    except subprocess.TimeoutExpired:
        return f"{words[0]} took longer than {limit_s:.0f} s; --limit allows more"
    if done.returncode in (0, 3):  # 3: the logger lost frames, which the analysis says too
        return ""
    said = [line.strip() for line in done.stderr.strip().splitlines() if line.strip()]
    named = f"swaywatch {words[0]}: "
    at = max((i for i, line in enumerate(said) if line.startswith(named)), default=len(said) - 1)
    text = " ".join(said[max(at, 0) :]) or f"{words[0]} ended with exit code {done.returncode}"
    return text.removeprefix(named)


def _read_analysis(outcome: Outcome, place: Path, link: str) -> None:
    drive = json.loads((place / "summary.json").read_text())["drives"][0]
    outcome.conclusion = next(iter(drive["conclusion"]), "")
    critical = drive["values"].get("v_crit_m_s")
    if critical is not None:
        outcome.v_crit_kmh = critical["value"] * 3.6
        outcome.v_crit_se_kmh = critical["standard_error"] * 3.6
    order = ("normal", "notice", "warning", "critical")
    states = [alarm["state"] for alarm in drive["alarms"]]
    outcome.alarm = max(states, key=lambda s: order.index(s) if s in order else -1, default="")
    outcome.pages["margin"] = f"{link}/report.html"


def _read_diagnosis(outcome: Outcome, place: Path, link: str, problem: str) -> None:
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
    outcome.why = [_why(effect) for effect in found["effects"]]
    outcome.why += [str(note.get("reason", "")) for note in found["unexplained"]]
    if not found["model"]:
        outcome.state = "cannot say"
    else:
        outcome.state = "agrees" if found["verdict"] == "consistent" else "disagrees"


def _where(effect: dict[str, Any]) -> str:
    spans = when(effect["window_details"], "run 1") or "all along"
    lines = ", ".join(effect["lines"])
    return f"{part(effect['component'])}: {spans}" + (f", at {lines}" if lines else "")


def _why(effect: dict[str, Any]) -> str:
    values = "; ".join(text.removeprefix("run 1: ") for text in how_much(effect))
    what = named(f"{effect['id']}:{effect['component']}")
    text = f"{what}: {values}; confidence {effect['confidence']:.2f}"
    if effect["equivalent"]:
        text += f"; cannot be told from {', '.join(effect['equivalent'])}"
    return text


def _write(out: Path, outcomes: list[Outcome]) -> None:
    content = {"format": 1, "runs": [asdict(outcome) for outcome in outcomes]}
    with whole_file(out / "survey.json") as temporary:
        temporary.write_text(json.dumps(content, indent=1), encoding="utf-8")


def _kept(out: Path) -> dict[str, Outcome]:
    """Outcomes of an earlier survey into the same folder; what failed is tried again."""
    try:
        content = json.loads((out / "survey.json").read_text(encoding="utf-8"))
        found = [Outcome(**entry) for entry in content["runs"]]
    except (OSError, ValueError, TypeError, KeyError):
        return {}
    return {outcome.name: outcome for outcome in found if outcome.state != "failed"}
