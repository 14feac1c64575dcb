"""The page of a survey: which runs disagree with the model, where, and why."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from swaywatch.report.shell import document, plot, wide
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
        text += f"; {unlike} {'is' if unlike == 1 else 'are'} unlike the rest of the fleet"
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
    items = "".join(
        f"<li>{html.escape(name)}: {count} run{'s' if count > 1 else ''}</li>"
        for name, count in often
    )
    parts = [
        f"<div class='verdict {kind}'><p>{html.escape(count_words(alone))}.</p>"
        f"<ul>{items}</ul></div>",
        *_fleet(alone),
        "<h2>Runs</h2>",
        _table(order[:MOST_ROWS]),
        _left_out(len(order)),
        "<div class='note'>Mismatch: residual of the fit in units of the noise measured, of the "
        "model as it is and with what was found; about 1 is noise. Each run is judged by itself; "
        "the link leads to the maps, signals and figures behind it.</div>",
    ]
    if together:
        parts += [
            "<h2>Runs of one combination, together</h2>",
            "<div class='note'>Runs that disagree, explained by one model: stronger evidence than "
            "each alone.</div>",
            _table(together),
        ]
    title = "Which runs disagree with the model, where, and why"
    return document(title, parts, meta=f"{folder}, made in {took}")


def _left_out(count: int) -> str:
    if count <= MOST_ROWS:
        return ""
    return (
        f"<div class='note'>The first {MOST_ROWS} of {count} runs; all of them are in "
        "survey.parquet.</div>"
    )


def _fleet(alone: Sequence[SurveyOutcome]) -> list[str]:
    """What is unlike the other runs; nothing where there are too few to say so."""
    comparisons = compare(alone)
    if not comparisons:
        return []
    most = strength(comparisons, len(alone))
    unlike = sorted(
        (place for place, outcome in enumerate(alone) if outcome.stands_out),
        key=lambda place: -most[place],
    )
    rows = "".join(_unlike_row(alone[place]) for place in unlike[:MOST_ROWS])
    head = "<tr><th>run</th><th>what is unlike the others</th><th>alarm</th><th></th></tr>"
    found = wide(f"<table>{head}{rows}</table>") if unlike else "<p>No run stands out.</p>"
    return [
        "<h2>Unlike the rest of the fleet</h2>",
        found,
        plot(_picture(comparisons, alone), name="fleet"),
        "<div class='note'>Each measured value against what vehicle.toml says, compared with the "
        "same of all other runs. Zero is the median; one is the scatter of the fleet and the "
        f"value's own standard error together. Beyond {limit(comparisons):.1f} (dashed) one normal "
        "fleet in a hundred has a run. Of those within 2.5 only some are drawn.</div>",
    ]


def _unlike_row(outcome: SurveyOutcome) -> str:
    cells = [html.escape(outcome.name), _lines(outcome.stands_out), outcome.alarm, _links(outcome)]
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


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


def _table(outcomes: Sequence[SurveyOutcome]) -> str:
    head = (
        "<tr><th>run</th><th></th><th>where and when</th><th>why</th>"
        "<th>mismatch,<br>without → with</th>"
        "<th>critical speed [km/h]</th><th>alarm</th><th></th></tr>"
    )
    return wide(f"<table>{head}{''.join(_row(outcome) for outcome in outcomes)}</table>")


def _row(outcome: SurveyOutcome) -> str:
    cells = [
        html.escape(outcome.name),
        f"<span class='verdict-word {_COLOUR[outcome.state]}'>{outcome.state}</span>",
        _lines(outcome.where),
        _lines(outcome.why),
        _mismatch(outcome),
        ""
        if outcome.v_crit_kmh is None
        else f"{outcome.v_crit_kmh:.1f} ± {outcome.v_crit_se_kmh:.1f}",
        outcome.alarm,
        _links(outcome),
    ]
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _links(outcome: SurveyOutcome) -> str:
    return " ".join(
        f"<a href='{html.escape(path, quote=True)}'>{title}</a>"
        for title, path in outcome.pages.items()
    )


def _lines(texts: Sequence[str]) -> str:
    return "<br>".join(html.escape(text) for text in texts)


def _mismatch(outcome: SurveyOutcome) -> str:
    if outcome.mismatch is None:
        return ""
    after = "" if outcome.mismatch_after is None else f" → {outcome.mismatch_after:.1f}"
    return f"{outcome.mismatch:.1f}{after if outcome.effects else ''}"
