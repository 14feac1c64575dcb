"""Diagnosis of a car alone: steering and speed in, yaw rate and lateral acceleration compared.

A real car has no file with its cornering stiffnesses; they are fitted with the rest. What is
claimed is therefore what no stiffness explains, and what predicts the runs it was not fitted to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.diagnose.car_alone.data import CarData, load_car_runs
from swaywatch.diagnose.car_alone.effects import ACC, YAW, CarEffect, bank_effect, effects
from swaywatch.diagnose.car_alone.fit import CarFitter, CarModel
from swaywatch.diagnose.car_alone.relations import (
    RelationFit,
    bank_angles,
    banked,
    believed_roll,
    relations,
    roll_per_acceleration,
    yaw_gain_range,
)
from swaywatch.diagnose.model import embedded, signals_for
from swaywatch.effects.runs import RATE_HZ
from swaywatch.errors import RecordingError
from swaywatch.vehicle import Car, Vehicle

Progress = Callable[[str, float], None]

#: An explanation stays if left-out runs are predicted worse by this share without it.
WORTH = 0.01
#: Explanations that leave no more than this share more of the mismatch are equals.
EQUAL = 0.02
#: or regain all but this share of what the claim is worth.
SHARED = 0.15
#: Confidence of a roll that the relation of acceleration, speed and yaw rate shows by itself, in
#: each part of the runs: then it does not hang on what a simulation is made of.
SHOWN = 0.9
ROLL_QUANTITY = "roll_per_lateral_acceleration_deg_per_m_s2"
ROLL_SEEN = "roll_that_the_accelerometer_alone_says_deg_per_m_s2"
#: Steps of a fit that starts from a neighbour's values.
REFIT = 5
#: Without an explanation the fit must get worse by this share, else it goes unjudged;
NEEDED = 0.01
#: if by this one, it stays for now and is judged in the end.
CLEARLY = 0.05
#: Most confidence of an explanation that the fit wants and left-out parts do not confirm.
UNCONFIRMED = 0.3
#: Lift and drive force are looked for above this speed, m/s.
FAST = 25.0


@dataclass
class Claim:
    """One explanation that stays, what the others do without it, and what would do as well."""

    effect: CarEffect
    mean_square_without: float
    held_out_without: float
    equals: list[tuple[str, float]] = field(default_factory=list)


@dataclass
class CarVerdict:
    """What the search ends with.

    Attributes
    ----------
    baseline, model
        Without and with the claimed explanations.
    claims
        Most important first.
    held_out
        Mean NRMSE of left-out folds: of the baseline and of the model.
    ranking
        Explanations alone on the baseline: name, mean square, values.
    dropped
        What was taken away and why, in sentences.
    """

    baseline: CarModel
    model: CarModel
    claims: list[Claim]
    held_out: tuple[float, float]
    ranking: list[tuple[str, float, dict[str, float]]]
    dropped: list[str] = field(default_factory=list)


def _candidates(data: CarData, found: list[RelationFit]) -> list[CarEffect]:
    """Explanations to try; the wheels limit what the yaw rate can be wrong by."""
    top = max(float(np.max(run.channels["speed"])) for run in data.runs)
    everything = effects(data.channels, fast=top > FAST)
    allowed = yaw_gain_range(found)
    if allowed is not None:
        everything = [_limited(e, allowed) for e in everything]
    turn = next((f.value for f in found if f.name.startswith("lateral acceleration")), 1.0)
    windows = banked(data, float(np.clip(turn, 0.9, 1.2)))
    if windows:
        everything.append(replace(bank_effect(windows), usual=True))
    return everything


def _limited(effect: CarEffect, allowed: tuple[float, float]) -> CarEffect:
    if effect.name != f"sensor_gain:{YAW}":
        return effect
    return replace(effect, numbers=(replace(effect.numbers[0], low=allowed[0], high=allowed[1]),))


def _mean_held_out(fitter: CarFitter, model: CarModel) -> float:
    folds = fitter.held_out(model)
    return float(np.mean([scores["all"] for _, _, scores in folds])) if folds else float("nan")


def _with(
    fitter: CarFitter, model: CarModel, added: Sequence[CarEffect], steps: int = 12
) -> CarModel:
    values = dict(model.values)
    for effect in added:
        values |= {f"{effect.name}/{n.name}": n.start for n in effect.numbers}
    return fitter.fit(
        CarModel((*model.effects, *added), values, model.steering_offset),
        fitter.data.parts,
        steps=steps,
    )


def _without(fitter: CarFitter, model: CarModel, effect: CarEffect) -> CarModel:
    rest = tuple(e for e in model.effects if e.name != effect.name)
    values = {k: v for k, v in model.values.items() if not k.startswith(effect.name + "/")}
    return fitter.fit(CarModel(rest, values, model.steering_offset), fitter.data.parts, steps=REFIT)


def _significance(model: CarModel, effect: CarEffect) -> float:
    """Largest distance of its numbers from neutral, in their standard errors."""
    found = 0.0
    for n in effect.numbers:
        key = f"{effect.name}/{n.name}"
        # a friction of a tyre that saturates: what counts is how far from the linear one it is
        away = 1.0 / model.values[key] if np.isinf(n.neutral) else model.values[key] - n.neutral
        error = model.errors.get(key, 0.0)
        error = error / model.values[key] ** 2 if np.isinf(n.neutral) else error
        if n.known is None or abs(n.known[0] - n.neutral) < 1e-9 or np.isinf(n.neutral):
            found = max(found, abs(away) / max(error, 1e-9))
    return found


def search(fitter: CarFitter, everything: Sequence[CarEffect], progress: Progress) -> CarVerdict:
    """All that a real car has at once, then without what left-out runs do not need.

    Taken one at a time explanations of a real car hide each other: roll, saturating tyres, a banked
    road and a wrong steering ratio are all there together.
    """
    parts = fitter.data.parts
    baseline = fitter.fit(fitter.start(), parts)
    before = _mean_held_out(fitter, baseline)
    ranking = []
    for i, effect in enumerate(everything):
        progress("each explanation alone", 0.3 * (i + 1) / len(everything))
        alone = _with(fitter, baseline, [effect], REFIT)
        ranking.append((effect.name, alone.mean_square, alone.of(effect)))
    ranking.sort(key=lambda item: item[1])
    dropped: list[str] = []
    model = _everything(fitter, baseline, everything, ranking, dropped)
    reached = _mean_held_out(fitter, model)
    claims: list[Claim] = []
    weakest_first = sorted(model.effects, key=lambda e: _significance(model, e))
    for i, effect in enumerate(weakest_first):
        progress("what is needed", 0.3 + 0.4 * (i + 1) / len(weakest_first))
        rest = _without(fitter, model, effect)
        worse = rest.mean_square / model.mean_square - 1.0
        if worse > CLEARLY:
            claims.append(Claim(effect, rest.mean_square, np.nan))
            continue
        if worse > NEEDED:
            score = _mean_held_out(fitter, rest)
            # a single fold cannot be held out: then the fit decides
            worse = worse if np.isnan(score) else score / reached - 1.0
            if worse > WORTH:
                claims.append(Claim(effect, rest.mean_square, score))
                continue
            reached = score
        dropped.append(f"{effect.name}: not needed ({100 * worse:+.1f} % without it)")
        model = rest
    model = fitter.fit(model, parts)
    reached = _mean_held_out(fitter, model)
    for i, claim in enumerate(claims):
        progress("equivalents", 0.7 + 0.25 * (i + 1) / len(claims))
        claim.equals = _equals(fitter, model, claim, everything)
    claims.sort(key=lambda c: (-np.nan_to_num(c.held_out_without), -c.mean_square_without))
    return CarVerdict(baseline, model, claims, (before, reached), ranking, dropped)


def _everything(
    fitter: CarFitter,
    baseline: CarModel,
    usual: Sequence[CarEffect],
    ranking: Sequence[tuple[str, float, dict[str, float]]],
    dropped: list[str],
) -> CarModel:
    """All usual explanations at once, added one after another, the strongest first.

    Near the limit a car is unstable at a fixed steering angle: from a far start the simulation
    would run away and no step would lead back.
    """
    place = {name: i for i, (name, _, _) in enumerate(ranking)}
    model = baseline
    for effect in sorted((e for e in usual if e.usual), key=lambda e: place[e.name]):
        trial = _with(fitter, model, [effect], REFIT)
        if trial.mean_square < model.mean_square:
            model = trial
        else:
            dropped.append(f"{effect.name}: no improvement in addition to the others")
    return fitter.fit(model, fitter.data.parts)


def _equals(
    fitter: CarFitter, model: CarModel, claim: Claim, everything: Sequence[CarEffect]
) -> list[tuple[str, float]]:
    """Explanations that do as well in its place."""
    taken = {e.name for e in model.effects}
    rest = _without(fitter, model, claim.effect)
    # what it is worth in the company that is left
    claim.mean_square_without, claim.held_out_without = (
        rest.mean_square,
        _mean_held_out(fitter, rest),
    )
    if rest.mean_square < (1.0 + EQUAL) * model.mean_square:
        return []
    found = []
    limit = model.mean_square + max(
        EQUAL * model.mean_square, SHARED * (rest.mean_square - model.mean_square)
    )
    for effect in everything:
        if effect.name not in taken and not effect.windows:
            other = _with(fitter, rest, [effect], REFIT - 2)
            if other.mean_square < limit:
                found.append((effect.name, other.mean_square))
    return sorted(found, key=lambda item: item[1])


def diagnose_car_alone(
    recordings: Sequence[Path],
    vehicle: Vehicle,
    signals: Path,
    progress: Progress,
    report: Path | None = None,
) -> dict[str, Any]:
    """Diagnose runs of one car without a trailer. Returns the content of diagnosis.json."""
    from swaywatch.diagnose.car_alone.page import car_page
    from swaywatch.diagnose.report.page import write_page

    data = load_car_runs(recordings, vehicle, signals)
    if not data.parts:
        reasons = data.cannot or ["cannot say: no part of the recordings can be used"]
        return {
            "format": 1, "verdict": "unexplained", "effects": [],
            "unexplained": [{"reason": text} for text in reasons], "model": {},
            "checks": [*data.checks, *reasons],
        }  # fmt: skip
    found = relations(data)
    fitter = CarFitter(data)
    verdict = search(fitter, _candidates(data, found), progress)
    progress("judging", 0.95)
    result = _result(fitter, verdict, found)
    result["signals"] = embedded(signals)
    result["inputs"] = {
        "recordings": [str(path) for path in recordings],
        "vehicle": str(vehicle.path), "signals": str(signals),
    }  # fmt: skip
    if report is not None:
        text = car_page(result, fitter, verdict.baseline, verdict.model)
        write_page(text, report)
    progress("done", 1.0)
    return result


def _result(fitter: CarFitter, verdict: CarVerdict, found: list[RelationFit]) -> dict[str, Any]:
    data = fitter.data
    entries = data.faults.entries(data.signals)
    quantities = _quantities(fitter, verdict)
    shown = quantities.get(ROLL_SEEN, {}).get("low", 0.0) > 0.0
    entries = [_effect(fitter, verdict, claim, shown) for claim in verdict.claims] + entries
    entries.sort(key=lambda entry: entry["id"] != "sensor_roll_gravity" or not shown)
    kinds = [entry["kind"] for entry in entries]
    word = "consistent"
    if kinds:
        word = {"measurement": "measurement_fault", "parameter": "parameter_error"}.get(
            kinds[0], "missing_physics"
        )
        if "physics" in kinds:
            word = "missing_physics"
    fitted = [n.name for n in fitter.fitted]
    checks = list(data.checks) + data.cannot
    if fitted:
        checks.append(
            f"{', '.join(fitted)}: not in vehicle.toml, fitted to the recordings; so an "
            "explanation that acts like a stiffness (steering_compliance, roll_steer, "
            "parameter_error of a stiffness or of the mass) cannot be distinguished from it"
        )
    rest = fitter.nrmse(verdict.model, data.parts)
    return {
        "format": 1,
        "verdict": word,
        "effects": entries,
        "unexplained": _remaining(rest),
        "quantities": quantities,
        "relations": [finding.as_dict() for finding in found],
        "model": car_block(fitter, verdict),
        "checks": checks,
        "evidence": {
            "level_without": verdict.baseline.mean_square, "level_with": verdict.model.mean_square,
            "level_clean": 1.0,
            "ranking": [
                {"name": n, "level": v, "values": values} for n, v, values in verdict.ranking
            ],
            "held_out_nrmse": list(verdict.held_out), "dropped": verdict.dropped,
        },
    }  # fmt: skip


def _remaining(rest: dict[str, float]) -> list[dict[str, Any]]:
    return [
        {
            "reason": f"{name}: {value:.0%} of its variation (RMS) is not explained",
            "channel": name, "nrmse": value,
        }
        for name, value in rest.items() if name != "all" and value > 0.05
    ]  # fmt: skip


def _effect(
    fitter: CarFitter, verdict: CarVerdict, claim: Claim, roll_is_shown: bool
) -> dict[str, Any]:
    effect, data = claim.effect, fitter.data
    before, after = claim.held_out_without, verdict.held_out[1]
    worse = before / after - 1.0
    if np.isnan(worse):
        worse = claim.mean_square_without / verdict.model.mean_square - 1.0
    sure = 0.5 + 0.45 * (1.0 - float(np.exp(-8.0 * max(worse, 0.0))))
    if worse <= 0.0:
        sure = UNCONFIRMED
    if effect.id == "sensor_roll_gravity" and roll_is_shown:
        sure = max(sure, SHOWN)
    if claim.equals:
        sure *= 0.6
    folds = [m for _, m, _ in fitter.held_out(verdict.model)]
    parameters = {}
    for number in effect.numbers:
        key = f"{effect.name}/{number.name}"
        value = verdict.model.values[key]
        # leaving out a fold moves a value by what the runs disagree (jackknife)
        spread = [m.values[key] for m in folds]
        n = len(spread)
        jack = float(np.sqrt((n - 1) * np.var(spread))) if n > 1 else 0.0
        half = 1.645 * max(verdict.model.errors.get(key, 0.0), jack)
        room = 1e-3 * (number.high - number.low)
        parameters[number.name] = {
            "value": value, "low": value - half, "high": value + half,
            "at_bound": not number.low + room < value < number.high - room,
        }  # fmt: skip
    base = fitter.nrmse(verdict.baseline, data.parts)["all"]
    best = fitter.nrmse(verdict.model, data.parts)["all"]
    windows = [[max(a, 0.0), min(b, float(data.runs[r].time[-1]))] for r, a, b in effect.windows]
    return {
        "id": effect.id,
        "parameters": parameters,
        "component": data.signals.get(effect.component, effect.component),
        "role": effect.component,
        "windows": windows,
        "window_details": [
            {"run": data.runs[r].name, "start": w[0], "stop": w[1]}
            for (r, _, _), w in zip(effect.windows, windows, strict=True)
        ],
        "lines": list(effect.lines),
        "confidence": round(sure, 3),
        "equivalent": sorted({name.split(":")[0] for name, _ in claim.equals}),
        "equivalent_details": [name for name, _ in claim.equals],
        "distinguished_by": effect.decided_by if claim.equals else "",
        "equation": effect.equation, "source": effect.source, "kind": effect.kind,
        "fit": {
            "baseline_nrmse": base, "diagnosed_nrmse": best,
            "held_out_baseline_nrmse": verdict.held_out[0],
            "held_out_diagnosed_nrmse": verdict.held_out[1],
            "held_out_without_this_nrmse": before,
            "iso18571_before": None, "iso18571_after": None,
        },
    }  # fmt: skip


def _quantities(fitter: CarFitter, verdict: CarVerdict) -> dict[str, Any]:
    """What an independent instrument could have measured, from single relations."""
    data = fitter.data
    if not all(c in data.channels for c in (YAW, ACC)):
        return {}
    banks = [w for e in verdict.model.effects for w in e.windows]
    extra, parts = [], []
    for part in data.parts:
        outputs = fitter.outputs(verdict.model, part)
        run = data.runs[part.run]
        first, last = run.time[part.start], run.time[part.stop - 1]
        if any(r == part.run and a < last and b > first for r, a, b in banks):
            continue
        rate = np.gradient(outputs["lateral_velocity"]) * RATE_HZ
        extra.append(rate + run.position_m * np.gradient(outputs["true_yaw_rate"]) * RATE_HZ)
        parts.append((part.run, part.where))
    found = {}
    values = roll_per_acceleration(data, extra, parts)
    if values:
        seen, error, known, left = np.degrees(believed_roll(values))
        found[ROLL_SEEN] = {
            "value": seen, "low": seen - 1.645 * error, "high": seen + 1.645 * error,
            "per_part": np.degrees(values).tolist(),
            "how": "(a_y measured / (v_x * yaw rate + dv_y/dt) - 1) / g in each part; true if "
            "nothing but the roll of the body and the sensors' gains (2 % of acceleration and yaw "
            "rate, 1 % of speed) make the difference",
        }  # fmt: skip
        found[ROLL_QUANTITY] = {
            "value": known, "low": known - 1.645 * left, "high": known + 1.645 * left,
            "how": "the same combined with typical values of cars, 0.56 +- 0.18 (sports car 0.31, "
            "soft family car 0.87): a gain of the acceleration would look alike",
        }  # fmt: skip
    for number, (run_number, start, stop) in enumerate(banks, start=1):
        roll = np.radians(found[ROLL_SEEN]["value"]) if found else 0.0
        angles = bank_angles(data.runs[run_number], start, stop, roll)
        if angles.size > 1:
            half = 1.645 * float(np.std(angles)) / np.sqrt(angles.size - 1)
            middle = float(np.mean(angles))
            found[f"road_bank_{number}_deg"] = {
                "value": middle, "low": middle - half, "high": middle + half,
                "how": f"{data.runs[run_number].name}, {max(start, 0.0):.0f} s to "
                f"{min(stop, data.runs[run_number].time[-1]):.0f} s: (v_x * yaw rate - a_y / "
                "(1 + g roll)) / g in stretches of 2 s; positive pulls to the left",
            }  # fmt: skip
    return found


def car_block(fitter: CarFitter, verdict: CarVerdict) -> dict[str, Any]:
    """What `predict` needs."""
    car = fitter.data.vehicle.car
    return {
        "kind": "solo",
        "vehicle": {f"car.{k}": v for k, v in vars(car).items() if v is not None},
        "baseline": {n.name: verdict.baseline.values[n.name] for n in fitter.fitted},
        "diagnosed": {n.name: verdict.model.values[n.name] for n in fitter.fitted},
        "terms": [
            {
                "id": e.id, "component": e.component, "values": verdict.model.of(e),
                "windows": [list(w) for w in e.windows],
            }
            for e in verdict.model.effects
        ],
    }  # fmt: skip


def predict_car_alone(
    content: dict[str, Any], recording: Path, signals: Path | None
) -> dict[str, Any]:
    """Baseline and diagnosed model of a car alone against one run."""
    block = content["model"]
    car = Car(**{k.removeprefix("car."): v for k, v in block["vehicle"].items()})
    with signals_for(content, recording, signals) as (source, words):
        data = load_car_runs([recording], Vehicle(car, None), source)
    if not data.parts:
        raise RecordingError(f"{recording}: {'; '.join(data.cannot)}")
    fitter = CarFitter(data)
    known = {e.name: e for e in effects(data.channels)}
    used, values, left = [], dict(block["diagnosed"]), []
    for term in block["terms"]:
        name = f"{term['id']}:{term['component']}"
        if term["windows"] or name not in known:
            left.append(name)
            continue
        used.append(known[name])
        values |= {f"{name}/{k}": v for k, v in term["values"].items()}
    result: dict[str, Any] = {
        "recording": recording.name, "signals": words, "simulation": None,
        "taken_from_recording": [
            "steering wheel angle", "speed", "yaw rate at the first sample of each part",
            "offset of the steering: fitted to the run",
            "offset of each channel (at standstill, and the mean of each part)",
        ],
        "effects_applied": [e.name for e in used], "effects_in_windows": left,
        "notes": [f"{name}: belongs to a place and time of the diagnosed runs" for name in left],
    }  # fmt: skip
    for word, model in (
        ("baseline", CarModel((), dict(block["baseline"]), {})),
        ("diagnosed", CarModel(tuple(used), values, {})),
    ):
        offset = fitter.fit(model, data.parts, free=False)
        scores = fitter.nrmse(offset, data.parts)
        result[f"{word}_nrmse"] = scores.pop("all")
        result[f"{word}_nrmse_by_channel"] = scores
        result[f"{word}_iso18571"] = None
    return result
