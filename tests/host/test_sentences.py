"""A diagnosis in plain sentences."""

from __future__ import annotations

from typing import Any

import pytest

from swaywatch.commands.physics import known
from swaywatch.diagnose.effect import library
from swaywatch.diagnose.sentences import _SENTENCES, sentence


def _effect(name: str, component: str, **values: float) -> dict[str, Any]:
    return {
        "id": name, "component": component, "window_details": [],
        "parameters": {k: {"value": v, "low": v, "high": v} for k, v in values.items()},
    }  # fmt: skip


def test_an_axle_load_that_swings() -> None:
    effect = _effect("axle_load_harmonic", "car_rear", amplitude_n=760.0)
    effect["window_details"] = [{"run": "run 1", "start": 9.5, "stop": 12.5, "amplitude_n": 760.0}]
    stability = {"without": {}, "left_out": ["axle_load_harmonic:car_rear"]}
    assert sentence(effect, stability) == (
        "The load of the car's rear axle swings by 760 N at twice the yaw frequency; a damper is "
        "the usual cause (run 1: 9.5 to 12.5 s); it has no critical speed of its own."
    )


@pytest.mark.parametrize(
    ("with_it", "without", "words"),
    [
        (120.0, 124.5, "it costs 4.5 km/h of critical speed (124.5 to 120.0 km/h)"),
        (130.0, 124.5, "it adds 5.5 km/h of critical speed (124.5 to 130.0 km/h)"),
        (124.5, 124.5, "it does not move the critical speed"),
        (124.5, None, "124.5 km/h with it, none is found without"),
        (None, 124.5, "no critical speed is found with it"),
    ],
)
def test_what_it_does_to_the_critical_speed(
    with_it: float | None, without: float | None, words: str
) -> None:
    effect = _effect("hitch_friction", "hitch", moment_nm=150.0)
    stability = {"without": {"hitch_friction:hitch": without}, "v_crit_diagnosed_km_h": with_it}
    text = sentence(effect, stability)
    assert text.startswith("The hitch rubs with 150 N m; ")
    assert words in text


def test_every_effect_has_a_sentence_and_none_breaks_without_numbers() -> None:
    assert {effect.id for effect in library()} == set(_SENTENCES)
    assert set(_SENTENCES) <= set(known())
    for name in known():
        text = sentence(_effect(name, "car_rear"))
        assert text.endswith(".")
        assert "{" not in text
        assert "None" not in text
