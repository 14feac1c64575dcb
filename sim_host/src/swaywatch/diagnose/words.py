"""An effect of diagnosis.json in words, the same on every page and screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def how_much(effect: Mapping[str, Any]) -> list[str]:
    """Parameters with 90 % intervals; of an effect in several windows a line for each window.

    A mean over windows would say nothing: a phase of +56 deg here and -151 deg there is no -49 deg.
    """
    parameters = effect["parameters"]
    details = effect.get("window_details") or []
    if len(details) > 1:
        return [
            f"{d['run']} {d['start']:.1f} to {d['stop']:.1f} s: "
            + ", ".join(f"{name} {d[name]:.4g}" for name in parameters if name in d)
            for d in details
        ]
    return [
        ", ".join(
            f"{name} {v['value']:.4g} ({v['low']:.4g} to {v['high']:.4g})"
            for name, v in parameters.items()
        )
    ]
