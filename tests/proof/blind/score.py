"""Score diagnoses against the answers; the only program that reads the answers.

``python score.py --answers DIR --diagnoses DIR --out FILE`` prints tables and writes a JSON file.
What counts as right:

- clean case: verdict ``consistent``. An effect that is named there is a false claim.
- one effect: the first effect has the concealed id (``first``), or the concealed id is the first
  one's or among those it calls equivalent (``set``).
- two effects: the first is one of the two; both named is counted apart.
- outside the library: verdict ``unexplained``, or a list ``unexplained`` that is not empty and no
  effect with confidence of 90 % or more. A faulty sensor: also ``measurement_fault`` that names it.

Above its limit is an effect that leaves ten standard deviations in its own recordings beside the
best wrong one (``case_limits.py``, from the truth alone; `information.NAMEABLE`).
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

from information import NAMEABLE

Json = dict[str, Any]
RUNS = ("run1", "run2", "run3")
NOT_PARAMETERS = {"id", "axle", "body", "channel", "parameter", "side", "law", "sensing",
                  "share_of_roll", "delay"}  # fmt: skip
#: Standard deviations beside the best wrong effect. `NAMEABLE` is about twice that of the road
#: recordings (README of the proof): half of it is an edge too.
LEFT = (
    (0.0, 3.0), (3.0, 0.5 * NAMEABLE), (0.5 * NAMEABLE, NAMEABLE), (NAMEABLE, 30.0), (30.0, 100.0),
    (100.0, float("inf")),
)  # fmt: skip
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.85), (0.85, 0.95), (0.95, 1.01))


def load(path: Path) -> Json | None:
    """JSON file, or nothing where there is none."""
    if not path.exists():
        return None
    value: Json = json.loads(path.read_text())
    return value


def plain(word: object) -> str:
    """A name in lower case with underscores."""
    return str(word).strip().lower().replace(" ", "_").replace("-", "_").replace(".", "_")


def located(effect: Json, truth: Json, component: str) -> bool:
    """The effect says where: component, or its axle, body, channel or parameter."""
    said = {plain(effect.get("component", ""))}
    for key in ("axle", "body", "channel", "parameter"):
        value = effect.get("parameters", {}).get(key, effect.get(key))
        if value is not None:
            said.add(plain(value.get("value") if isinstance(value, dict) else value))
    wanted = {plain(component)} | {
        plain(truth[key]) for key in ("axle", "body", "channel", "parameter") if key in truth
    }
    general = {"tyres", "road", "steering", "hitch"}
    if plain(component) in general:
        return True
    return any(w and (w == s or w in s or s in w) for w in wanted for s in said if s)


def per_run(windows: Any) -> dict[str, list[list[float]]]:
    """Windows by run; a bare list of pairs is taken as of run 1."""
    if isinstance(windows, dict):
        return {plain(run): list(pairs) for run, pairs in windows.items()}
    out: dict[str, list[list[float]]] = defaultdict(list)
    for item in windows or []:
        if isinstance(item, dict):
            run = item.get("run", 0)
            number = run + 1 if isinstance(run, int) else re.sub(r"\D", "", str(run)) or 1
            run = f"run{number}"
            start = next((item[key] for key in ("start", "start_s") if key in item), 0.0)
            stop = next((item[key] for key in ("stop", "end", "stop_s") if key in item), start)
            out[run].append([float(start), float(stop)])
        else:
            out["run1"].append(list(item[:2]))
    return dict(out)


def overlap(said: list[list[float]], true: list[list[float]]) -> float:
    """Intersection over union of two sets of time windows."""
    step = 0.05
    cells = range(int(60 / step))

    def mask(windows: list[list[float]]) -> list[bool]:
        return [any(a <= i * step < b for a, b in windows) for i in cells]

    pairs = list(zip(mask(said), mask(true), strict=True))
    union = sum(a or b for a, b in pairs)
    return sum(a and b for a, b in pairs) / union if union else 1.0


def numbers(truth: Json) -> dict[str, float]:
    """Parameters of an answer that are numbers."""
    return {
        key: float(value)
        for key, value in truth.items()
        if key not in NOT_PARAMETERS and isinstance(value, (int, float))
    }


def parameters(effect: Json, truth: Json) -> list[Json]:
    """Relative error and interval of each parameter that both have."""
    out = []
    for name, true in numbers(truth).items():
        said = effect.get("parameters", {}).get(name)
        if isinstance(said, (int, float)):
            said = {"value": said}
        if not isinstance(said, dict) or not isinstance(said.get("value"), (int, float)):
            continue
        deviation = name == "factor"  # of 1: the error counts against what was changed
        scale = abs(true - 1.0) if deviation else abs(true)
        row: Json = {"name": name, "error": abs(said["value"] - true) / max(scale, 1e-9)}
        if isinstance(said.get("low"), (int, float)) and isinstance(said.get("high"), (int, float)):
            row["inside"] = said["low"] <= true <= said["high"]
        out.append(row)
    return out


def measured_harmonic(answer: Json) -> dict[str, float]:
    """Median amplitude of a harmonic load as it was in the windows of the runs given out."""
    found = [w["amplitude_n"] for run in RUNS[:2] for w in answer[run].get("harmonic", [])]
    middle = median(found)
    return {} if middle is None else {"amplitude_n": middle}


def phase_errors(effect: Json, answer: Json, windows: Json) -> list[float]:
    """Degrees between said and true phase of a harmonic load, window by window."""
    out = []
    for item in effect.get("window_details") or []:
        phase = item.get("phase_deg")
        phase = phase.get("value") if isinstance(phase, dict) else phase
        for run, pairs in per_run([item]).items():
            truths = answer.get(run, {}).get("harmonic", [])
            for window, truth in zip(windows.get(run, []), truths, strict=False):
                if phase is not None and overlap(pairs, [window]) >= 0.3:
                    out.append(abs((phase - truth["phase_deg"] + 180.0) % 360.0 - 180.0))
    return out


def match(effects: list[Json], truth: Json, component: str, windows: Json) -> Json:
    """How well the claimed effects fit one concealed effect."""
    named = [e for e in effects if e.get("id") == truth["id"]]
    out: Json = {"id": truth["id"], "named": bool(named), "location": None, "overlap": None}
    if not named:
        return out
    effect = next((e for e in named if located(e, truth, component)), named[0])
    out["location"] = located(effect, truth, component)
    out["parameters"] = parameters(effect, truth)
    if windows and effect.get("windows"):
        said = per_run(effect.get("window_details") or effect["windows"])
        shared = [overlap(said[run], windows[run]) for run in said if windows.get(run)]
        out["overlap"] = sum(shared) / len(shared) if shared else 0.0
    elif windows:
        out["overlap"] = 0.0
    return out


def judge_outside(answer: Json, verdict: str, effects: list[Json], rest: list[Any]) -> bool:
    """Whether a cause outside the library was recognised as such."""
    sure = any(float(e.get("confidence", 0.0)) >= 0.9 for e in effects)
    if verdict == "unexplained" or (rest and not sure):
        return True
    if answer["fault"] != [True] or verdict != "measurement_fault":
        return False
    return any(located(e, answer["effects"][0], answer["components"][0]) for e in effects)


def _with_harmonic(answer: Json, truth: Json) -> Json:
    """The answer with what its load amounted to, where it is a harmonic load."""
    return truth | measured_harmonic(answer) if truth["id"] == "axle_load_harmonic" else truth


def judge(answer: Json, diagnosis: Json) -> Json:
    """All judgements of one case."""
    verdict = str(diagnosis.get("verdict", ""))
    effects = [e for e in diagnosis.get("effects", []) if isinstance(e, dict)]
    rest = list(diagnosis.get("unexplained", []))
    first = effects[0] if effects else {}
    truths = answer["effects"]
    ids = [t["id"] for t in truths]
    claims = verdict not in ("consistent", "unexplained", "") and bool(effects)
    confidence = first.get("confidence") if claims else diagnosis.get("confidence")
    out: Json = {
        "verdict": verdict,
        "first_id": first.get("id") if claims else None,
        "claims": claims,
        "silent": verdict == "consistent",
        "confidence": confidence,
    }
    if not truths:
        out["first"] = out["set"] = verdict == "consistent"
        return out
    if any(answer["outside"]):
        out["first"] = out["set"] = judge_outside(answer, verdict, effects, rest)
        return out
    chosen = {first.get("id"), *first.get("equivalent", [])} if claims else set()
    out["first"] = claims and first.get("id") in ids
    out["set"] = bool(chosen & set(ids))
    out["all"] = claims and set(ids) <= {e.get("id") for e in effects}
    out["matches"] = [
        match(effects if claims else [], _with_harmonic(answer, t), c, w)
        for t, c, w in zip(truths, answer["components"], answer["windows"], strict=True)
    ]
    out["phase_errors_deg"] = [
        error
        for effect in effects
        for truth, windows in zip(truths, answer["windows"], strict=True)
        if effect.get("id") == truth["id"] == "axle_load_harmonic"
        for error in phase_errors(effect, answer, windows)
    ]
    return out


def find(tree: Any, names: tuple[str, ...]) -> float | None:
    """First number under one of these names anywhere in a JSON tree."""
    if isinstance(tree, dict):
        for name in names:
            if isinstance(tree.get(name), (int, float)):
                return float(tree[name])
        tree = list(tree.values())
    if isinstance(tree, list):
        for item in tree:
            value = find(item, names)
            if value is not None:
                return value
    return None


def held_out(secret: Path, result: Path) -> Json | None:
    """Prediction of the run that was left out, by ``swaywatch predict``; cached."""
    out, model = result / "prediction.json", result / "diagnosis.json"
    if not out.exists() or out.stat().st_mtime < model.stat().st_mtime:
        run = next(secret.glob("run3.*"), None)
        if run is None:
            return None
        line = [sys.executable, "-m", "swaywatch.cli", "predict", "--model", str(model),
                "--recording", str(run), "--out", str(out)]  # fmt: skip
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return {"failed": done.stderr[-500:]}
    tree = load(out)
    before = find(tree, ("baseline_nrmse", "nrmse_baseline"))
    after = find(tree, ("diagnosed_nrmse", "nrmse_diagnosed"))
    if before is None or after is None:
        return None
    # an effect in windows cannot be predicted; scored apart where the run shows it
    shown = find(tree, ("diagnosed_with_windows_nrmse",))
    return {"before": before, "after": after, "with_windows": shown}


def above(row: Json) -> bool:
    """Every concealed effect can be named beside the best wrong one."""
    return bool(row["left"]) and min(row["left"]) >= NAMEABLE


def share(values: list[bool]) -> Json:
    """Right ones of all."""
    return {"right": sum(values), "of": len(values),
            "share": round(sum(values) / len(values), 4) if values else None}  # fmt: skip


def median(values: list[float]) -> float | None:
    """Median, or nothing of nothing."""
    ordered = sorted(values)
    return ordered[len(ordered) // 2] if ordered else None


def by_effect(rows: list[Json]) -> Json:
    """Figures of single-effect cases, by effect."""
    groups: dict[str, list[Json]] = defaultdict(list)
    for row in rows:
        if row["kind"] in ("planar", "simulation"):
            label = row["ids"][0] + ("/simulation" if row["kind"] == "simulation" else "")
            groups[label].append(row)
    out: Json = {}
    for label, cases in sorted(groups.items()):
        found = [m for row in cases for m in row.get("matches", []) if m["named"]]
        values = [p for m in found for p in m.get("parameters", [])]
        strong = [row for row in cases if above(row)]
        out[label] = {
            "first": share([bool(r["first"]) for r in cases]),
            "set": share([bool(r["set"]) for r in cases]),
            "silent": sum(bool(r["silent"]) for r in cases),
            "above_limit": share([bool(r["first"]) for r in strong]),
            "location": share([bool(m["location"]) for m in found]),
            "overlap_median": median([m["overlap"] for m in found if m["overlap"] is not None]),
            "parameter_error_median": median([p["error"] for p in values]),
            "coverage": share([p["inside"] for p in values if "inside" in p]),
        }
    return out


def by_limit(rows: list[Json]) -> list[Json]:
    """Named rightly, by the standard deviations that the effect leaves beside the best wrong one.

    Shows what the rate above the limit owes to where the limit is.
    """
    out = []
    for low, high in LEFT:
        hit = [r for r in rows if r["left"] and low <= min(r["left"]) < high]
        if hit:
            out.append({"from": low, "to": high if high < float("inf") else None,
                        **share([bool(r["first"]) for r in hit])})  # fmt: skip
    return out


def missed(rows: list[Json]) -> list[Json]:
    """Cases above the limit in which not all that is concealed is named."""
    return [
        {"case": r["case"], "ids": r["ids"], "tier": r["tier"], "left": r["left"],
         "best_wrong": r["best_wrong"], "said": r["first_id"] or r["verdict"] or "no verdict"}
        for r in rows
        if above(r) and not r["all" if len(r["ids"]) > 1 else "first"]
    ]  # fmt: skip


def calibration(rows: list[Json]) -> list[Json]:
    """Right by name against the confidence that was stated."""
    out = []
    for low, high in BINS:
        hit = [
            r for r in rows
            if r["claims"] and isinstance(r["confidence"], (int, float))
            and low <= r["confidence"] < high
        ]  # fmt: skip
        if hit:
            stated = sum(r["confidence"] for r in hit) / len(hit)
            out.append({"from": low, "to": min(high, 1.0), "stated": round(stated, 3),
                        **share([bool(r["first"]) for r in hit])})  # fmt: skip
    return out


def summarise(rows: list[Json]) -> Json:
    """All figures of the set."""
    singles = [r for r in rows if r["kind"] in ("planar", "simulation")]
    clean = [r for r in rows if not r["ids"]]
    pairs = [r for r in rows if r["kind"] == "pair"]
    held = [r["held_out"] for r in rows if r.get("held_out") and "before" in r["held_out"]
            and r["first"] and r["claims"]]  # fmt: skip
    predicted = [h for h in held if h["after"] != h["before"]]
    shown = [h for h in held if h["after"] == h["before"] and h.get("with_windows") is not None]
    matches = [m for r in rows for m in r.get("matches", []) if m["named"]]
    values = [p for m in matches for p in m.get("parameters", [])]
    return {
        "cases": len(rows),
        "failed": sum(bool(r.get("failed")) for r in rows),
        "first": share([bool(r["first"]) for r in singles]),
        "set": share([bool(r["set"]) for r in singles]),
        "first_above_limit": share([bool(r["first"]) for r in singles if above(r)]),
        "without_limit": sum(not r["left"] for r in [*singles, *pairs]),
        "false_claims_on_clean": share([bool(r["claims"]) for r in clean]),
        "clean_consistent": share([bool(r["first"]) for r in clean]),
        "pair_first": share([bool(r["first"]) for r in pairs]),
        "pair_both": share([bool(r.get("all")) for r in pairs]),
        "pair_both_above_limit": share([bool(r.get("all")) for r in pairs if above(r)]),
        "outside": share([bool(r["first"]) for r in rows if r["kind"] == "outside"]),
        "fault_outside": share([bool(r["first"]) for r in rows if r["kind"] == "fault"]),
        "location": share([bool(m["location"]) for m in matches]),
        "windows_overlap_half": share(
            [m["overlap"] >= 0.5 for m in matches if m["overlap"] is not None]
        ),
        "harmonic_phase_error_median_deg": median(
            [e for r in rows for e in r.get("phase_errors_deg", [])]
        ),
        "parameter_within_25_percent": share([p["error"] <= 0.25 for p in values]),
        "interval_coverage": share([p["inside"] for p in values if "inside" in p]),
        "held_out_improved": share([h["after"] < h["before"] for h in predicted]),
        "held_out_same": len(held) - len(predicted),
        "held_out_windows_improved": share([h["with_windows"] < h["before"] for h in shown]),
        "held_out_before_median": median([h["before"] for h in predicted]),
        "held_out_after_median": median([h["after"] for h in predicted]),
        "seconds_median": median([r["seconds"] for r in rows if r.get("seconds")]),
        "seconds_max": max([r["seconds"] for r in rows if r.get("seconds")], default=None),
        "simulated_s_median": median([r["simulated_s"] for r in rows if r.get("simulated_s")]),
        "simulated_s_max": max(
            [r["simulated_s"] for r in rows if r.get("simulated_s")], default=None
        ),
        "calibration": calibration(rows),
        "by_limit": by_limit(singles),
        "missed_above_limit": missed([*singles, *pairs]),
        "effects": by_effect(rows),
    }


def text(value: Any) -> str:
    """A figure for the table."""
    if isinstance(value, dict):
        return f"{value['right']}/{value['of']}" if value["of"] else "-"
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


COLUMNS = (
    ("first", "first"), ("set", "set"), ("silent", "silent"), ("above_limit", "above"),
    ("location", "where"), ("overlap_median", "overlap"), ("parameter_error_median", "par.err"),
    ("coverage", "cover"),
)  # fmt: skip


def print_tables(total: Json, rows: list[Json]) -> None:
    """Human-readable tables."""
    print(f"{'effect':34s}" + "".join(f"{head:>9s}" for _, head in COLUMNS))
    for label, figures in total["effects"].items():
        print(f"{label:34s}" + "".join(f"{text(figures[key]):>9s}" for key, _ in COLUMNS))
    print()
    for key, value in total.items():
        if not isinstance(value, list) and key != "effects":
            extra = f"  ({value['share']:.1%})" if isinstance(value, dict) and value["of"] else ""
            print(f"{key:32s}{text(value)}{extra}")
    for row in total["calibration"]:
        print(
            f"stated {row['from']:.2f}-{row['to']:.2f} (mean {row['stated']:.2f}): "
            f"right {text(row)}"
        )
    for row in total["by_limit"]:
        print(f"{interval(row)} standard deviations beside the best wrong: right {text(row)}")
    print_missed(total["missed_above_limit"])
    print_confused(rows)
    for r in rows:
        if r.get("failed"):
            print(f"failed: {r['case']}: {' '.join(r['failed'].split())}")


def print_confused(rows: list[Json]) -> None:
    """What was said in place of what was concealed."""
    confused: dict[tuple[str, str], int] = defaultdict(int)
    for r in rows:
        if not r["first"] and r["kind"] in ("planar", "simulation", "clean", "clean_simulation"):
            confused[("+".join(r["ids"]) or "clean", str(r["first_id"] or r["verdict"]))] += 1
    print("\nnot right: concealed -> said")
    for (true, said), count in sorted(confused.items(), key=lambda item: -item[1]):
        print(f"  {count:3d}  {true} -> {said}")


def interval(row: Json) -> str:
    """Standard deviations of a row of `by_limit`, in words."""
    return f"{row['from']:g} to {row['to']:g}" if row["to"] else f"{row['from']:g} or more"


def print_missed(rows: list[Json]) -> None:
    """What was not named although it is above the limit."""
    for r in rows:
        limits = " + ".join(
            f"{name} {left:.0f} (beside {wrong or 'nothing'})"
            for name, left, wrong in zip(r["ids"], r["left"], r["best_wrong"], strict=True)
        )
        print(f"missed above the limit: {r['case']} {r['tier']}: {limits} -> {r['said']}")


def score(answers: Path, diagnoses: Path, *, predict: bool) -> list[Json]:
    """One row per case that was diagnosed."""
    rows = []
    for path in sorted(answers.glob("*/answer.json")):
        answer = load(path) or {}
        result = diagnoses / path.parent.name
        run = load(result / "run.json")
        diagnosis = load(result / "diagnosis.json")
        if run is None and diagnosis is None:
            continue
        limits = (load(path.parent / "limit.json") or {}).get("limits", [])
        row: Json = {
            "case": answer["case"],
            "kind": answer["kind"],
            "tier": answer.get("tier"),
            "left": [own["name"] for own in limits],
            "best_wrong": [own["best_wrong"] for own in limits],
            "ids": [t["id"] for t in answer["effects"]],
            "strength": answer["strengths"][0] if answer["strengths"] else 0.0,
            "value": answer["values"][0] if answer["values"] else 0.0,
            "visibility": answer["run1"]["visibility"],
            "hidden": answer["hidden_channels"],
            "seconds": (run or {}).get("seconds"),
            "simulated_s": (diagnosis or {}).get("evidence", {}).get("simulated_s"),
            "failed": None if diagnosis else (run or {}).get("said", "no diagnosis.json"),
        }
        row |= judge(answer, diagnosis or {})
        if predict and diagnosis and row["claims"]:
            row["held_out"] = held_out(path.parent, result)
        rows.append(row)
    return rows


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--diagnoses", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--no-predict", action="store_true", help="leave the held-out runs alone")
    given = parser.parse_args()
    rows = score(given.answers, given.diagnoses, predict=not given.no_predict)
    if not rows:
        sys.exit(f"no diagnosis in {given.diagnoses} belongs to an answer in {given.answers}")
    total = summarise(rows)
    print_tables(total, rows)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps({"summary": total, "cases": rows}, indent=1))


if __name__ == "__main__":
    main()
