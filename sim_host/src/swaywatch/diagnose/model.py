"""The diagnosed model as data: what `predict` needs, written into diagnosis.json and read back.

Nothing in it depends on the machine that made it: the role mapping and the DBC files travel inside.
"""

from __future__ import annotations

import dataclasses
import json
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from swaywatch.diagnose.fit.beliefs import Belief, Beliefs
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.drive import load_signals
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.errors import SignalError, SwaywatchError
from swaywatch.plant.lanes import BODY
from swaywatch.toml_file import load_toml


def model_block(
    problem: Problem, fit: Fit, baseline: Fit, written: Fit | None = None
) -> dict[str, Any]:
    """Constants of the file, effects with raw values, calibration to the user's simulation."""
    block: dict[str, Any] = {
        "kind": "combination",
        "vehicle": dict(zip(BODY, problem.body.tolist(), strict=True)),
        "steering_ratio": problem.runs[0].steering_ratio,
        "beliefs": [dataclasses.asdict(b) for b in problem.beliefs.items],
        "care": problem.beliefs.care,
        "given": [list(pair) for pair in problem.given],
        "shift": fit.shift.tolist(),
        "shift_calibrated": baseline.shift.tolist(),
        "shift_as_written": None if written is None else written.shift.tolist(),
        "runs": [
            {"name": run.name, "duration_s": float(run.time[-1] - run.time[0])}
            for run in problem.runs
        ],
        "terms": _entries(fit.terms),
    }
    if problem.calibration and problem.start_shift is not None:
        block["calibration"] = {"terms": _entries(problem.calibration)}
    return block


def beliefs_in(model: dict[str, Any]) -> Beliefs:
    """Beliefs of a model block."""
    if "beliefs" not in model:
        raise SwaywatchError(
            "the model is of an older version of swaywatch, without tolerances; diagnose again"
        )
    items = tuple(Belief(**entry) for entry in model["beliefs"])
    return Beliefs(items, float(model["care"]))


def _entries(terms: Sequence[ActiveEffect]) -> list[dict[str, Any]]:
    return [
        {
            "id": t.effect.id,
            "component": t.effect.component,
            "form": t.effect.extra.get("form"),
            "values": list(t.values),
            "window_runs": list(t.window_runs),
        }
        for t in terms
    ]


def terms_of(
    entries: Sequence[dict[str, Any]], effects: Sequence[Effect]
) -> tuple[ActiveEffect, ...]:
    """Active effects of a model block, windows included."""
    found = []
    for entry in entries:
        same = [e for e in effects if e.id == entry["id"] and e.component == entry["component"]]
        form = entry.get("form")
        effect = next((e for e in same if e.extra.get("form") == form), None)
        if effect is None and form == "generator":
            effect = _generator(entry["component"])
        if effect is None and "/" in str(form):
            effect = _law(entry["id"], str(form))
        if effect is None:
            raise SwaywatchError(
                f"the model holds {entry['id']} at {entry['component']}, "
                "which is not in the library"
            )
        found.append(ActiveEffect(effect, _values(effect, entry), tuple(entry["window_runs"])))
    return tuple(found)


def _law(id_: str, spec: str) -> Effect:
    """A law that a diagnosis found, under its own id or the one that a user's file gave it."""
    from swaywatch.discover.effect import effect_of_form

    return replace(effect_of_form(spec), id=id_)


def _values(effect: Effect, entry: dict[str, Any]) -> tuple[float, ...]:
    """Values of an entry; parameters that a module has gained since then are neutral."""
    values = [float(v) for v in entry["values"]]
    want = len(effect.parameters)
    if effect.windowed:
        count = len(entry["window_runs"])
        stride = len(values) // max(count, 1)
        if stride * count != len(values) or not 3 <= stride <= 2 + want:
            raise SwaywatchError(f"the model's windows of {effect.name} do not fit the library")
        gained = [p.neutral for p in effect.parameters[stride - 2 :]]
        rows = [values[w * stride : (w + 1) * stride] for w in range(count)]
        return tuple(v for row in rows for v in (*row, *gained))
    if len(values) > want:
        raise SwaywatchError(
            f"the model holds {len(values)} values of {effect.name}; the library knows {want}"
        )
    return (*values, *(p.neutral for p in effect.parameters[len(values) :]))


def _generator(axle: str) -> Effect:
    from swaywatch.effects.library.axle_load_harmonic import generator_effect

    return generator_effect(axle)


def read_model(path: Path) -> dict[str, Any]:
    """A diagnosis.json (or a committed verdict) that holds a model."""
    try:
        content = json.loads(path.read_text())
    except OSError as error:
        raise SwaywatchError(f"{path}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise SwaywatchError(f"{path}: not a diagnosis.json ({error})") from error
    model = content.get("model") if isinstance(content, dict) else None
    if not model:
        if isinstance(content, dict) and "verdict" in content:
            raise SwaywatchError(
                f"{path}: holds no model: the diagnosis ended with the verdict "
                f"{content['verdict']!r}, without one that could predict"
            )
        raise SwaywatchError(
            f"{path}: holds no model: it is no result of `swaywatch diagnose`; --model takes the "
            "diagnosis.json in the folder of its --out"
        )
    return dict(content)


def embedded(signals: Path) -> dict[str, Any]:
    """The role mapping and the text of its DBC files."""
    _, databases = load_signals(signals)
    return {
        "roles": load_toml(signals, SignalError, "signals.toml")["signals"],
        "dbc": [{"name": path.name, "text": _text(path)} for path in databases],
    }


def _text(path: Path) -> str:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise SignalError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


@contextmanager
def signals_for(
    content: dict[str, Any], recording: Path, given: Path | None
) -> Iterator[tuple[Path, str]]:
    """The role mapping of a run, and words for where it comes from.

    In this order: the one given, `signals.toml` beside the recording (if its DBC files are there),
    the one inside the model, the path at which the diagnosis read it.
    """
    if given is not None:
        yield given, f"{given} (given)"
        return
    beside = recording.parent / "signals.toml"
    if beside.exists() and all(path.exists() for path in load_signals(beside)[1]):
        yield beside, f"{beside.name} beside the recording"
        return
    inside = content.get("signals")
    if inside:
        with tempfile.TemporaryDirectory() as folder:
            yield _unpacked(inside, Path(folder)), "the mapping inside the model"
        return
    recorded = (content.get("inputs") or {}).get("signals")
    if recorded and Path(recorded).exists():
        yield Path(recorded), f"{recorded} (path in the model)"
        return
    raise SignalError(
        f"{recording}: no role mapping: none inside the model, no signals.toml beside the "
        "recording; add --signals signals.toml"
    )


def _unpacked(inside: dict[str, Any], folder: Path) -> Path:
    """Write mapping and DBC files side by side."""
    names = []
    for index, entry in enumerate(inside["dbc"]):
        names.append(f"{index}_{Path(entry['name']).name}")
        (folder / names[-1]).write_text(entry["text"], encoding="utf-8")
    lines = [f"dbc = {_toml(names)}"] if names else []
    lines += ["[signals]", *(f"{role} = {_toml(value)}" for role, value in inside["roles"].items())]
    path = folder / "signals.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _toml(value: Any) -> str:
    """A value of a role mapping in TOML: text, number, list or table."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return json.dumps(value, ensure_ascii=False)
