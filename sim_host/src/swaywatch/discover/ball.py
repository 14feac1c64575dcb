"""A ball that moves across its coupling: with play, elastically with friction, or to one side.

Its place is a displacement, which follows the force on it: the plant's elastic drawbar, whose
spring may have a play, or another stiffness to the right, and whose seat may rub.
"""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.discover.law import LOST_MOTION, UNEVEN, Law
from swaywatch.effects.effect import Act, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: Of what holds it beyond its play, or in its seat: softest, and stiffest that steps allow.
_SOFT, _STIFF = 1e-4, 2e-6
_HELD = Parameter("compliance", "m/N", 0.0, _STIFF, _SOFT, (2.5e-6,), 1e-6, 1e9)
_PLAY = Parameter("play_m", "m", 0.0, 0.0, 0.03, (0.001, 0.004), 2e-4, 3e-4)
_GIVES = Parameter("compliance", "m/N", 0.0, 0.0, _SOFT, (1e-5, 3e-5), 1e-6, 2e-6)
_TO_A_SIDE = Parameter("compliance", "m/N", 0.0, _STIFF, _SOFT, (4e-6, 1.5e-5), 1e-6, 2e-6)
_OTHER = Parameter("other_side", "1", 1.0, 0.02, 40.0, (0.2, 5.0), 0.1, 1e9)
_RUBS = Parameter("friction_n", "N", 0.0, 0.0, 2000.0, (50.0, 200.0), 10.0, 10.0)

#: Why such a law has no critical speed.
NO_STIFFNESS = "within its play nothing holds the ball: no single critical speed belongs to it"


def moves_in_coupling(law: Law) -> tuple[Act, tuple[Parameter, ...], str]:
    """Act, parameters and equation of a ball that has play, slips, or gives way to one side."""
    if law.shape == UNEVEN:
        equation = "F_ball = y / compliance, to the right (y < 0) times the other side"
        return _act, (_TO_A_SIDE, _OTHER), equation
    if law.shape == LOST_MOTION:
        return _act, (_PLAY, _HELD), "F_ball = (y beyond +-play) / compliance"
    return _act, (_GIVES, _RUBS), "F_ball = y / compliance + friction sign(dy/dt)"


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("drawbar_compliance", max(values["compliance"], 0.0))
    plant.scalar("drawbar_play", max(values.get("play_m", 0.0), 0.0))
    plant.scalar("drawbar_friction", max(values.get("friction_n", 0.0), 0.0))
    # no side stiffer than the steps allow
    stiffest = max(values["compliance"], _STIFF) / _STIFF
    plant.scalar("drawbar_other_side", min(values.get("other_side", 1.0), stiffest) - 1.0)
