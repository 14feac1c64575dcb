"""An effect that values within their tolerances make up for is found from the file's vehicle."""

from __future__ import annotations

from dataclasses import replace

import pytest
from test_diagnose import effect, synthetic

from swaywatch.diagnose.evidence.evidence import CLAIMED
from swaywatch.diagnose.evidence.search import Search, reduced_chi_square
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library


@pytest.mark.parametrize("coefficient", [-0.12, 0.12])
def test_an_effect_that_the_calibrated_vehicle_hides_is_found(coefficient: float) -> None:
    """The trailer's axles steer with its roll; its tyres, mass and lengths can nearly do the same.

    The calibrated vehicle leaves hardly more than the effect does, and no course from it shows
    the effect.
    """
    steers = effect("roll_steer:trailer")
    rest = tuple(p.neutral for p in steers.parameters[1:])
    truth = synthetic((ActiveEffect(steers, (coefficient, *rest)),), seed=1)
    beliefs = beliefs_of(truth.body, truth.channels(truth.runs[0]))
    lasting = [e for e in library() if not e.windowed]
    search = Search(replace(truth, beliefs=beliefs), lasting, lambda stage, share: None)
    base = search.baseline()
    found = search.extend(base.fit, windowed=False)
    assert reduced_chi_square(base.fit) < 1.05 * reduced_chi_square(found[0].fit)
    assert found[0].names == ("roll_steer:trailer",)
    assert found[0].evidence > search.weighed(base).evidence + CLAIMED
    assert found[0].fit.terms[0].values[0] == pytest.approx(coefficient, rel=0.2)
    assert all(c.evidence < found[0].evidence - CLAIMED for c in found[1:])
