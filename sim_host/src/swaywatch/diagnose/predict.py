"""Run a diagnosed model on another run's inputs and score it against what was recorded."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.diagnose.data import load_with_body
from swaywatch.diagnose.effect import Effect, library
from swaywatch.diagnose.fit import predict_run
from swaywatch.diagnose.judge import FIVE_PERCENT, errors, iso18571, nrmse, start_values
from swaywatch.diagnose.plant import BODY
from swaywatch.diagnose.term import Term
from swaywatch.errors import SwaywatchError


def terms_of(model: dict[str, Any], effects: Sequence[Effect]) -> tuple[Term, ...]:
    """Terms of a model block, windows included."""
    found = []
    for entry in model.get("terms", []):
        for effect in effects:
            if (
                effect.id == entry["id"]
                and effect.component == entry["component"]
                and (effect.windowed or effect.extra.get("form") == entry.get("form"))
            ):
                found.append(Term(effect, tuple(entry["values"]), tuple(entry["window_runs"])))
                break
        else:
            raise SwaywatchError(
                f"the model holds {entry['id']} at {entry['component']}, "
                "which is not in the library"
            )
    return tuple(found)


def predict(model_file: Path, recording: Path, signals: Path | None = None) -> dict[str, Any]:
    """Baseline and diagnosed model against one run.

    The steering offset and the start values come from the first five seconds of the run; windows
    of the diagnosed runs are not carried over, for they belong to those runs.

    Returns
    -------
    dict
        ``baseline_nrmse``, ``diagnosed_nrmse``, per channel, ISO/TS 18571, 5 % criterion.
    """
    try:
        content = json.loads(model_file.read_text())
    except (OSError, ValueError) as error:
        raise SwaywatchError(f"{model_file}: not a diagnosis.json ({error})") from error
    model = content.get("model") or {}
    if "vehicle" not in model:
        raise SwaywatchError(f"{model_file}: holds no model (verdict {content.get('verdict')!r})")
    body = np.array([model["vehicle"][name] for name in BODY])
    source = signals if signals is not None else Path(content["inputs"]["signals"])
    problem = load_with_body(recording, source, body, float(model["steering_ratio"]))
    terms = tuple(t for t in terms_of(model, library()) if not t.effect.windowed)
    shared = np.array(model["load_transfer"])
    result: dict[str, Any] = {"recording": recording.name, "windows_carried_over": False}
    for word, used in (("baseline", ()), ("diagnosed", terms)):
        nuisance = start_values(problem, 0, used, shared)
        outputs = predict_run(problem, 0, used, nuisance, shared)
        channel = errors(problem, 0, outputs)
        result[f"{word}_nrmse"] = nrmse(channel)
        result[f"{word}_nrmse_by_channel"] = channel
        result[f"{word}_iso18571"] = iso18571(problem.runs[0], outputs)
        result[f"{word}_within_5_percent"] = sorted(
            name for name, value in channel.items() if value <= FIVE_PERCENT
        )
    return result
