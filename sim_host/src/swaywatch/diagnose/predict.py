"""Run a diagnosed model on another run's inputs and score it against what was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.car_alone.engine import predict_car_alone
from swaywatch.diagnose.evidence.search import Search
from swaywatch.diagnose.fit.agreement import FIVE_PERCENT, errors, iso18571, nrmse
from swaywatch.diagnose.fit.data import load_with_body
from swaywatch.diagnose.fit.fit import Fit, Problem, predict_run
from swaywatch.diagnose.fit.holdout import START_S, start_values, valued, values_of
from swaywatch.diagnose.fit.simulation import attach, rolling
from swaywatch.diagnose.model import beliefs_in, read_model, signals_for, terms_of
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.errors import RecordingError, SwaywatchError
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]

OBSERVER = 2.0  # 1/s, as in the search of the diagnosis
#: Windows that cover this share of every diagnosed run are no windows: the effect is permanent.
PERMANENT_SHARE = 0.9
#: A window found in the predicted run counts if it acts at least this much of what was diagnosed,
CLEAR_SHARE = 0.4
#: at most this many times as much,
CLEAR_MOST = 2.5
#: and takes at least this share of the mismatch away.
CLEAR_GAIN = 0.05
PASSES = 3  # simulations after which an effect that reacts to the motion has settled


def predict(
    model_file: Path,
    recording: Path,
    signals: Path | None = None,
    simulation: Path | None = None,
    simulation_signals: Path | None = None,
) -> dict[str, Any]:
    """Baseline and diagnosed model against one run.

    Parameters
    ----------
    model_file
        A diagnosis.json or a committed verdict.
    recording
        The run to predict, any format.
    signals
        Its role mapping (default: see `model.signals_for`).
    simulation
        The user's own simulation of this run, or an FMU; the diagnosed physics is then a
        correction to it.
    simulation_signals
        The roles of the simulation, where they are others.

    Returns
    -------
    dict
        ``as_written_nrmse`` (the vehicle of the file), ``baseline_nrmse`` (calibrated, without
        the findings), ``diagnosed_nrmse`` (all three pure predictions), per channel, ISO/TS 18571,
        5 % criterion; ``diagnosed_with_windows_nrmse`` where the diagnosis holds windows (their
        times are looked for in the run, so it is no prediction); what was taken from the run.
    """
    content = read_model(model_file)
    if not recording.exists():
        raise RecordingError(f"{recording}: no such file")
    if content["model"].get("kind") == "solo":
        if simulation is not None:
            raise SwaywatchError(f"{model_file}: a car alone: --simulation is not for it")
        return predict_car_alone(content, recording, signals)
    with signals_for(content, recording, signals) as (source, words):
        problem, notes = _problem(
            content["model"], recording, source, simulation, simulation_signals
        )
    if not problem.channels(problem.runs[0]):
        raise SwaywatchError(
            f"{recording}: only steering and speed are recorded: nothing to score against"
        )
    result: dict[str, Any] = {"recording": recording.name, "signals": words}
    result["simulation"] = None if simulation is None else simulation.name
    result["taken_from_recording"] = _taken(simulation)
    terms = terms_of(content["model"]["terms"], library())
    _check_springs(model_file, problem, terms)
    lasting, windowed = _split(terms, content["model"].get("runs", []), problem.runs[0])
    result["effects_applied"] = [t.effect.name for t in lasting]
    result["effects_in_windows"] = [t.effect.name for t in windowed]
    shift = np.array(content["model"]["shift"])
    calibrated = np.array(content["model"]["shift_calibrated"])
    models = [("baseline", (), calibrated), ("diagnosed", lasting, shift)]
    if content["model"].get("shift_as_written") is not None and simulation is None:
        models.insert(0, ("as_written", (), np.array(content["model"]["shift_as_written"])))
    for word, used, own in models:
        nuisance = start_values(problem, 0, _timeless(used), own)
        outputs = blind_run(problem, used, nuisance, own)
        result |= _scores(word, problem, outputs)
    if windowed:
        result |= _with_windows(problem, lasting, windowed, shift)
    result["notes"] = notes + _remarks(content["model"], simulation, windowed, result)
    beside = sorted(recording.parent.glob(f"simulation_{recording.stem}.*"))
    if simulation is None and beside:
        result["notes"].append(f"{beside[0].name} lies beside the recording and was not used")
    return result


def _problem(
    model: dict[str, Any],
    recording: Path,
    signals: Path,
    simulation: Path | None,
    simulation_signals: Path | None,
) -> tuple[Problem, list[str]]:
    """The run with the model's constants, and its simulation or the calibration to one."""
    body = np.array([model["vehicle"][name] for name in BODY])
    problem, notes = load_with_body(recording, signals, body, float(model["steering_ratio"]))
    given = tuple((str(name), float(value)) for name, value in model["given"])
    problem = replace(problem, beliefs=beliefs_in(model), given=given)
    known = model.get("calibration")
    calibration = terms_of(known["terms"], library()) if known else ()
    if simulation is not None:
        free, _, checks = attach(problem, [simulation], signals, calibration, simulation_signals)
        return free, notes + checks
    if known:
        # without the user's simulation of this run, the plant calibrated to his others is nearest
        shift = np.array(model["shift"])
        problem = replace(problem, calibration=calibration, start_shift=shift)
        start = start_values(problem, 0, (), shift)
        run = problem.runs[0]
        run.simulated.update(rolling(problem, 0, Fit((), start[None], shift)))
    return problem, notes


def _check_springs(model_file: Path, problem: Problem, terms: Sequence[ActiveEffect]) -> None:
    """What acts on springs needs them; models beside a simulation had none once."""
    for term in terms:
        if term.effect.extra.get("needs_springs") and not problem.on_springs:
            raise SwaywatchError(
                f"{model_file}: {term.effect.id} acts on springs, which this model does not have: "
                "it is of an older version of swaywatch; diagnose again"
            )


def _taken(simulation: Path | None) -> list[str]:
    """What the prediction knows of the run."""
    if simulation is not None:
        return [
            "steering and speed (those of the simulation)",
            "the offset of each channel (means are taken off before scoring)",
        ]
    return [
        "steering wheel angle", "speed",
        f"offset of the steering and start values: fitted to the first {START_S:.0f} s",
        "the offset of each channel (means are taken off before scoring)",
    ]  # fmt: skip


def _timeless(terms: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    return tuple(t for t in terms if not t.effect.windowed)


def _split(
    terms: Sequence[ActiveEffect], runs: Sequence[dict[str, Any]], run: Run
) -> tuple[tuple[ActiveEffect, ...], tuple[ActiveEffect, ...]]:
    """Active effects that last, and active effects in true windows.

    Windows that cover every diagnosed run from end to end become one over the predicted run.
    """
    lasting: list[ActiveEffect] = []
    windowed: list[ActiveEffect] = []
    for term in terms:
        if not term.effect.windowed:
            lasting.append(term)
        elif runs and all(
            _covered(term, index, float(entry["duration_s"])) >= PERMANENT_SHARE
            for index, entry in enumerate(runs)
        ):
            lasting.append(_everywhere(term, run))
        else:
            windowed.append(term)
    return tuple(lasting), tuple(windowed)


def _covered(term: ActiveEffect, index: int, duration_s: float) -> float:
    """Share of a run inside the windows of an active effect (windows do not overlap)."""
    inside = sum(
        min(w.stop, duration_s) - max(w.start, 0.0)
        for w in term.windows(index)
        if w.stop > 0.0 and w.start < duration_s
    )
    return inside / max(duration_s, 1e-9)


def _everywhere(term: ActiveEffect, run: Run) -> ActiveEffect:
    """One window over a whole run, with the mean of the values by length."""
    rows = np.array(term.values).reshape(-1, term.stride)
    mean = np.average(rows[:, 2:], axis=0, weights=rows[:, 1] - rows[:, 0])
    ends = (float(run.time[0]) - 1.0, float(run.time[-1]) + 1.0)
    return ActiveEffect(term.effect, (*ends, *(float(x) for x in mean)), (0,))


def blind_run(
    problem: Problem, terms: Sequence[ActiveEffect], nuisance: Array, shift: Array
) -> dict[str, Array]:
    """Predict the run without its outputs: effects that react to the motion see the simulated one.

    The run that the effects are given holds steering, speed and simulated channels, nothing else.
    """
    run = problem.runs[0]
    inputs = {name: run.channels[name] for name in ("steering_wheel_angle", "speed")}
    outputs = predict_run(problem, 0, _timeless(terms), nuisance, shift)
    if len(_timeless(terms)) == len(terms):
        return outputs
    for _ in range(PASSES):
        own = {k: v for k, v in run.simulated.items() if not k.startswith("_")}
        unseen = replace(run, channels=inputs | outputs, simulated=own)
        outputs = predict_run(replace(problem, runs=(unseen,)), 0, terms, nuisance, shift)
    return outputs


def _scores(word: str, problem: Problem, outputs: dict[str, Array]) -> dict[str, Any]:
    channel = errors(problem, 0, outputs)
    return {
        f"{word}_nrmse": nrmse(channel),
        f"{word}_nrmse_after_start": nrmse(_late(problem, outputs)),
        f"{word}_nrmse_by_channel": channel,
        f"{word}_iso18571": iso18571(problem.runs[0], outputs),
        f"{word}_within_5_percent": sorted(
            name for name, value in channel.items() if value <= FIVE_PERCENT
        ),
    }


def _late(problem: Problem, outputs: dict[str, Array]) -> dict[str, float]:
    """Errors after the part that the start values come from."""
    run, at = problem.runs[0], int(START_S * RATE_HZ)
    if run.time.size < 2 * at:
        return {}
    later = run.part(at, run.time.size)
    cut = {k: v[at:] for k, v in outputs.items()}
    return errors(replace(problem, runs=(later,)), 0, cut)


def _with_windows(
    problem: Problem,
    lasting: tuple[ActiveEffect, ...],
    windowed: Sequence[ActiveEffect],
    shift: Array,
) -> dict[str, Any]:
    """The diagnosed model with its windowed effects where the run shows them clearly.

    Times come from the run, values from the diagnosis. Labelled apart: it is no prediction.
    """
    timeless = _timeless(lasting)
    nuisance = start_values(problem, 0, timeless, shift)
    found: list[ActiveEffect] = []
    for term in windowed:
        spans = find_windows(problem, (*lasting, *found), term, nuisance, shift)
        if spans:
            candidates = values_of(term, sorted(set(term.window_runs)))
            used = (*lasting, *found)
            found.append(valued(problem, 0, used, term.effect, spans, candidates, nuisance, shift))
    outputs = predict_run(problem, 0, (*lasting, *found), nuisance, shift)
    result = _scores("diagnosed_with_windows", problem, outputs)
    result["windows_found"] = [
        {
            "id": term.effect.id, "component": term.effect.component,
            "start": round(w.start, 2), "stop": round(w.stop, 2), "values": dict(w.values),
        }
        for term in found for w in term.windows(0)
    ]  # fmt: skip
    return result


def find_windows(
    problem: Problem,
    terms: tuple[ActiveEffect, ...],
    term: ActiveEffect,
    nuisance: Array,
    shift: Array,
) -> list[tuple[float, float]]:
    """Times at which an effect acts in the run, by its own sign in the measured channels.

    The amplitude is free while looking, so that a window counts only if what is seen there has the
    size that was diagnosed.
    """
    from swaywatch.diagnose.evidence.locate import Locator

    own = bool(problem.runs[0].correction)
    seen = problem if own else replace(problem, observer=OBSERVER)
    same = [
        e for e in library()
        if (e.id, e.component) == (term.effect.id, term.effect.component)
    ]  # fmt: skip
    search = Search(seen, same, lambda stage, share: None)
    start = Fit(terms, nuisance[None, :], shift)
    parent = search.close.run(start, 6, free=0)
    plain = next((e for e in same if e.extra.get("form", "box") == "box"), same[0])
    locator = Locator(search.close, parent)
    fit = search.windowed(locator, locator.course(plain))
    if fit is None:
        return []
    fit = search.pruned(search.refined(fit))
    if fit.chi2 > (1.0 - CLEAR_GAIN) * parent.chi2:
        return []
    usual = np.median([_size(w) for w in _sizes(term)])
    rows = _sizes(fit.terms[-1])
    spans = [
        (w[0], w[1])
        for w in rows
        if CLEAR_SHARE * usual <= _size(w) <= CLEAR_MOST * usual and w[1] - w[0] > 0.5
    ]
    return sorted(spans)


def _sizes(term: ActiveEffect) -> list[list[float]]:
    """Start, stop and distances from neutral of each window, for the amplitudes of the effect."""
    rows = np.array(term.values).reshape(-1, term.stride)
    found = []
    for row in rows:
        parts = [
            float(value - p.neutral)
            for value, p in zip(row[2:], term.effect.parameters, strict=True)
            if p.name not in ("delay_s", "rise_s", "arm_m")
        ]
        found.append([float(row[0]), float(row[1]), *parts])
    return found


def _size(row: Sequence[float]) -> float:
    return float(np.hypot.reduce(np.array(row[2:])))


def _remarks(
    model: dict[str, Any],
    simulation: Path | None,
    windowed: Sequence[ActiveEffect],
    result: dict[str, Any],
) -> list[str]:
    """Sentences a reader of the scores should know."""
    notes = []
    if not model["terms"]:
        notes.append("the diagnosis claims no effect: both models are the same")
    if model.get("calibration") and simulation is None:
        notes.append(
            "diagnosed against the user's simulation, but none of this run is given "
            "(--simulation): the plant calibrated to the others is the baseline"
        )
    if windowed:
        names = ", ".join(t.effect.name for t in windowed)
        count = len(result["windows_found"])
        notes.append(
            f"{names}: acts in windows of the diagnosed runs, so it is not in diagnosed_nrmse; "
            f"{count} window(s) of it found in this run (diagnosed_with_windows_nrmse, no "
            "prediction: times come from the run)"
        )
    return notes
