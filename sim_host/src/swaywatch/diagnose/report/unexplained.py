"""What no explanation covers: where it enters, at which line, and whether it rings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.locate import AmplitudeCourse, Locator
from swaywatch.diagnose.fit.fit import Fit, Fitter
from swaywatch.diagnose.report.residual_map import yaw_frequency
from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

Array = NDArray[np.float64]

PULSE_S = 0.25

#: Places where something unknown can act, with the words of the report.
PLACES = {
    "force_car": "lateral balance of the car",
    "moment_car": "yaw balance of the car",
    "force_trailer": "lateral balance of the trailer",
    "moment_trailer": "yaw balance of the trailer",
}
_SCALE = {"force_car": 50.0, "moment_car": 50.0, "force_trailer": 50.0, "moment_trailer": 100.0}


def _act(slot: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        for window in windows:
            plant.add_series(slot, window.values["size"] * window.mask(run.time))

    return act


def _free(slot: str) -> Effect:
    return Effect(
        id="_unknown",
        component=slot,
        kind="physics",
        equation="an unknown force or moment",
        source="none",
        parameters=(Parameter("size", "N or Nm", 0.0, -1e6, 1e6, (1.0,), _SCALE[slot]),),
        act=_act(slot),
        windowed=True,
    )


def locate_rest(fitter: Fitter, fit: Fit) -> list[dict[str, Any]]:
    """Rank the places by how much of the rest an unknown force there would take away.

    Returns
    -------
    list of dict
        Place, share of chi2 it explains, dominant frequency of the course, ratio of that
        frequency to the yaw frequency, size; best first.
    """
    locator = Locator(fitter, fit)
    found = []
    for slot, words in PLACES.items():
        course = locator.course(_free(slot), ridge=1e-2, pulse_s=PULSE_S)
        frequency, sharpness = _ring(course)
        own = yaw_frequency(fitter.problem.runs[0])
        found.append(
            {
                "location": words,
                "slot": slot,
                "share_of_mismatch": course.gain / max(fit.chi2, 1e-9),
                "frequency_hz": frequency,
                "sharpness": sharpness,
                "line": _line(frequency, own),
                "rms": float(np.sqrt(np.mean([np.mean(a**2) for a in course.amplitude]))),
            }
        )
    found.sort(key=lambda entry: -float(str(entry["share_of_mismatch"])))
    for entry in found[:1]:
        entry["reason"] = (
            f"something acts in the {entry['location']} that no explanation of the library covers; "
            f"strongest at {entry['frequency_hz']:.2f} Hz ({entry['line']})"
        )
    return found


def _ring(course: AmplitudeCourse) -> tuple[float, float]:
    """Frequency with most power in the course (Hz) and its share of the power."""
    total: Array | None = None
    grid = np.linspace(0.1, 1.9, 91)
    for amplitude in course.amplitude:
        x = amplitude[:, 0] - amplitude[:, 0].mean()
        x = x * np.hanning(x.size)
        t = np.arange(x.size) * PULSE_S
        power = np.abs(np.exp(-2j * np.pi * np.outer(grid, t)) @ x) ** 2
        total = power if total is None else total + power
    assert total is not None
    top = int(np.argmax(total))
    near = np.abs(grid - grid[top]) < 0.12
    return float(grid[top]), float(total[near].sum() / total.sum())


def _line(frequency: float, own: float) -> str:
    for factor, word in ((1.0, "f"), (2.0, "2f"), (3.0, "3f")):
        if abs(frequency - factor * own) < 0.12:
            return word
    return "mean" if frequency < 0.2 else "broadband"
