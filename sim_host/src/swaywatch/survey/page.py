"""The page of a survey: which runs disagree with the model, where, and why."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from swaywatch.report.shell import document, plot
from swaywatch.survey.fleet import NAMES, FleetComparison, compare, limit, strength
from swaywatch.survey.outcome import STATES, SurveyOutcome

MOST_ROWS = 1000
"""Of a table; a browser gets slow beyond, and nobody reads them."""
MOST_POINTS = 400
"""Of a value near the median, in the picture."""

_COLOUR = {
    "disagrees": "bad", "agrees": "good", "cannot say": "near", "not diagnosed": "near",
    "failed": "near",
}  # fmt: skip


def count_words(outcomes: Sequence[SurveyOutcome]) -> str:
    """``3 of 20 runs disagree with the model, 15 agree, ...``."""
    number = Counter(outcome.state for outcome in outcomes)
    text = f"{number['disagrees']} of {len(outcomes)} runs disagree with the model"
    for state, words in (
        ("agrees", "agree"), ("cannot say", "cannot be judged"),
        ("not diagnosed", "were analysed only"), ("failed", "failed"),
    ):  # fmt: skip
        if number[state]:
            text += f", {number[state]} {words}"
    if unlike := sum(bool(outcome.stands_out) for outcome in outcomes):
        text += f"; {unlike} {'is an outlier' if unlike == 1 else 'are outliers'} of the fleet"
    return text


def make_page(
    folder: str, alone: Sequence[SurveyOutcome], together: Sequence[SurveyOutcome], took: str
) -> str:
    """HTML of a survey."""
    order = sorted(
        alone,
        key=lambda o: (STATES.index(o.state), not o.stands_out, -(o.mismatch or 0.0), o.name),
    )
    unlike = any(outcome.stands_out for outcome in alone)
    kind = "bad" if unlike or any(o.state == "disagrees" for o in alone) else "good"
    often = Counter(name for outcome in alone for name in outcome.effects).most_common(8)
    reasons = [f"{name}: {count} run{'s' if count > 1 else ''}" for name, count in often]
    return document(
        "survey/page.html",
        "Survey: which runs disagree with the model, where and why",
        meta=f"{folder}, made in {took}",
        verdict={"kind": kind, "sentence": f"{count_words(alone)}.", "reasons": reasons},
        fleet=_fleet(alone),
        alone=[_row(outcome) for outcome in order[:MOST_ROWS]],
        runs=len(order),
        together=[_row(outcome) for outcome in together],
    )


def _fleet(alone: Sequence[SurveyOutcome]) -> dict[str, Any] | None:
    """What is unlike the other runs; nothing where there are too few to say so."""
    comparisons = compare(alone)
    if not comparisons:
        return None
    most = strength(comparisons, len(alone))
    unlike = sorted(
        (place for place, outcome in enumerate(alone) if outcome.stands_out),
        key=lambda place: -most[place],
    )
    return {
        "unlike": [alone[place] for place in unlike[:MOST_ROWS]],
        "plot": plot(_picture(comparisons, alone), name="fleet"),
        "limit": limit(comparisons),
    }


def _picture(comparisons: Sequence[FleetComparison], alone: Sequence[SurveyOutcome]) -> go.Figure:
    """Distance of every run from the fleet, a row of points for each value."""
    figure = go.Figure()
    far = limit(comparisons)
    for row, entry in enumerate(comparisons):
        inside = np.flatnonzero(np.abs(entry.distance) < 2.5)
        thin = inside[:: max(1, len(inside) // MOST_POINTS)]
        shown = np.concatenate([thin, np.flatnonzero(np.abs(entry.distance) >= 2.5)])
        beyond = np.abs(entry.distance[shown]) > far
        figure.add_scatter(
            x=entry.distance[shown],
            y=row + 0.35 * np.sin(shown * 2.399963),  # spread, the same each time
            text=[html.escape(alone[entry.runs[k]].name) for k in shown],
            mode="markers",
            marker={
                "size": np.where(beyond, 10, 5),
                "color": np.where(beyond, "#dc2626", "#2563eb"),
                "opacity": 0.7,
            },
            hovertemplate="%{text}: %{x:.1f}<extra></extra>",
            showlegend=False,
        )
    for side in (-far, far):
        figure.add_vline(x=side, line={"dash": "dash", "width": 1, "color": "#9ca3af"})
    figure.update_xaxes(title_text="distance from the fleet [scatter]")
    figure.update_yaxes(
        tickvals=list(range(len(comparisons))), ticktext=[NAMES[c.name] for c in comparisons]
    )
    figure.update_layout(height=140 + 60 * len(comparisons), margin={"l": 230})
    return figure


def _row(outcome: SurveyOutcome) -> dict[str, Any]:
    """A run, the colour of its state and its numbers in words."""
    critical = outcome.v_crit_kmh
    return {
        "run": outcome,
        "colour": _COLOUR[outcome.state],
        "mismatch": _mismatch(outcome),
        "critical": "" if critical is None else f"{critical:.1f} ± {outcome.v_crit_se_kmh:.1f}",
    }


def _mismatch(outcome: SurveyOutcome) -> str:
    if outcome.mismatch is None:
        return ""
    after = "" if outcome.mismatch_after is None else f" → {outcome.mismatch_after:.1f}"
    return f"{outcome.mismatch:.1f}{after if outcome.effects else ''}"
