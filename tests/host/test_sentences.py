"""A diagnosis in plain sentences."""

from __future__ import annotations

from typing import Any

import pytest

from swaywatch.commands.physics import known
from swaywatch.diagnose.report.sentences import _SENTENCES, sentence
from swaywatch.effects.effect import library


def _effect(name: str, component: str, **values: float) -> dict[str, Any]:
    return {
        "id": name, "component": component, "window_details": [],
        "parameters": {k: {"value": v, "low": v, "high": v} for k, v in values.items()},
    }  # fmt: skip


def _stability(
    name: str, with_it: float | None, without: float | None, windows: tuple[float, ...] = ()
) -> dict[str, Any]:
    """As in diagnosis.json, the three swings alike."""

    def row(value: float | None) -> dict[str, float] | None:
        return None if value is None else {"value": value, "low": value - 1.0, "high": value + 1.0}

    back = None if with_it is None or without is None else without - with_it
    cause = {
        "name": name, "v_crit_without_km_h": 3 * [row(without)], "gives_back_km_h": 3 * [row(back)],
        "windows": [{"gives_back_km_h": row(value)} for value in windows],
    }  # fmt: skip
    return {"causes": [cause], "diagnosed": {"v_crit_km_h": 3 * [row(with_it)]}}


def test_an_axle_load_that_swings() -> None:
    effect = _effect("axle_load_harmonic", "car_rear", amplitude_n=760.0)
    effect["window_details"] = [
        {"run": "run 1", "start": start, "stop": start + 3.0, "amplitude_n": 760.0}
        for start in (9.5, 15.0)
    ]
    stability = _stability("axle_load_harmonic:car_rear", 118.8, 123.4, (4.6, -5.5))
    assert sentence(effect, stability) == (
        "The load of the car's rear axle swings by up to 760 N at twice the yaw frequency; a "
        "damper is the usual cause (run 1: 9.5 to 12.5 s, 15.0 to 18.0 s); it costs, in its worst "
        "window, 4.6 (3.6 to 5.6) km/h of critical speed (123.4 to 118.8 km/h) and adds 5.5 in its "
        "best."
    )
    assert sentence(effect, {"causes": []}).endswith("15.0 to 18.0 s).")


@pytest.mark.parametrize(
    ("with_it", "without", "words"),
    [
        (120.0, 124.5, "it costs 4.5 (3.5 to 5.5) km/h of critical speed (124.5 to 120.0 km/h)"),
        (130.0, 124.5, "it adds 5.5 (4.5 to 6.5) km/h of critical speed (124.5 to 130.0 km/h)"),
        (124.0, 124.5, "it costs 0.5 (0.0 to 1.5) km/h"),
        (124.5, 124.5, "it does not move the critical speed"),
        (124.5, None, "124.5 km/h with it, none is found without"),
        (None, 124.5, "no critical speed is found with it"),
    ],
)
def test_what_it_does_to_the_critical_speed(
    with_it: float | None, without: float | None, words: str
) -> None:
    effect = _effect("hitch_friction", "hitch", moment_nm=150.0)
    text = sentence(effect, _stability("hitch_friction:hitch", with_it, without))
    assert text.startswith("The hitch rubs with 150 N m; ")
    assert words in text


def test_what_acts_by_the_size_of_the_swing_says_of_which() -> None:
    stability = _stability("hitch_friction:hitch", 138.5, 123.2)
    stability["swings_deg_s"] = [1.0, 4.0, 10.0]
    stability["causes"][0]["gives_back_km_h"][2] = {"value": -5.9, "low": -6.2, "high": -5.6}
    text = sentence(_effect("hitch_friction", "hitch", moment_nm=130.0), stability)
    assert "(123.2 to 138.5 km/h) of a swing of 4 deg/s, 5.9 km/h of one of 10 deg/s." in text


def test_every_effect_has_a_sentence_and_none_breaks_without_numbers() -> None:
    assert {effect.id for effect in library()} == set(_SENTENCES)
    assert set(_SENTENCES) <= set(known())
    for name in known():
        text = sentence(_effect(name, "car_rear"))
        assert text.endswith(".")
        assert "{" not in text
        assert "None" not in text
