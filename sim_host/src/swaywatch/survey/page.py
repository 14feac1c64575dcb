"""The page of a survey: which runs disagree with the model, where, and why."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence

from swaywatch.report.shell import document, wide
from swaywatch.survey.work import STATES, Outcome

_COLOUR = {"disagrees": "bad", "agrees": "good", "cannot say": "near", "failed": "near"}


def count_words(outcomes: Sequence[Outcome]) -> str:
    """``3 of 20 runs disagree with the model, 15 agree, ...``."""
    number = Counter(outcome.state for outcome in outcomes)
    text = f"{number['disagrees']} of {len(outcomes)} runs disagree with the model"
    for state, words in (
        ("agrees", "agree"), ("cannot say", "cannot be judged"), ("failed", "failed"),
    ):  # fmt: skip
        if number[state]:
            text += f", {number[state]} {words}"
    return text


def make_page(folder: str, alone: Sequence[Outcome], together: Sequence[Outcome], took: str) -> str:
    """HTML of a survey."""
    order = sorted(alone, key=lambda o: (STATES.index(o.state), -(o.mismatch or 0.0), o.name))
    kind = "bad" if any(o.state == "disagrees" for o in alone) else "good"
    often = Counter(name for outcome in alone for name in outcome.effects).most_common(8)
    items = "".join(
        f"<li>{html.escape(name)}: {count} run{'s' if count > 1 else ''}</li>"
        for name, count in often
    )
    parts = [
        f"<div class='verdict {kind}'><p>{html.escape(count_words(alone))}.</p>"
        f"<ul>{items}</ul></div>",
        "<h2>Runs</h2>",
        _table(order),
        "<div class='note'>Mismatch: rest of the fit in units of the measurement's noise, of the "
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


def _table(outcomes: Sequence[Outcome]) -> str:
    head = (
        "<tr><th>run</th><th></th><th>where and when</th><th>why</th>"
        "<th>mismatch,<br>without → with</th>"
        "<th>critical speed [km/h]</th><th>alarm</th><th></th></tr>"
    )
    return wide(f"<table>{head}{''.join(_row(outcome) for outcome in outcomes)}</table>")


def _row(outcome: Outcome) -> str:
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
        " ".join(
            f"<a href='{html.escape(path, quote=True)}'>{title}</a>"
            for title, path in outcome.pages.items()
        ),
    ]
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _lines(texts: Sequence[str]) -> str:
    return "<br>".join(html.escape(text) for text in texts)


def _mismatch(outcome: Outcome) -> str:
    if outcome.mismatch is None:
        return ""
    after = "" if outcome.mismatch_after is None else f" → {outcome.mismatch_after:.1f}"
    return f"{outcome.mismatch:.1f}{after if outcome.effects else ''}"
