"""Table of physics that nobody lists: what was concealed, what was found, where, of what.

``python unlisted_score.py --answers DIR --diagnoses DIR --out FILE.md``. Found: a law at one of the
kind's places and of one or two of its variables (none beside them), and it predicts the kept-out
run better than the library. Of one that the library has under a name nothing else may be claimed; a
`law` is a claim of its own. The hint is the nearest law, where none is claimed.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

SEEN = 20.0
"""Largest RMS change of a signal over its noise from which a kind is to be found."""
AXLES = {"slip_car_front", "slip_car_rear", "slip_trailer"}
"""Places of a law that acts on every axle in turn."""
SAME = {"hitch_force": "side_force", "ball": "hitch"}
"""Words of a law for what the kinds call otherwise: the force on the ball, the ball's own place."""


def row(answer: Mapping[str, Any], result: Mapping[str, Any] | None) -> dict[str, Any]:
    """One case."""
    concealed = answer["effects"][0]
    seen = max(run["visibility"] for name, run in answer.items() if _is_run(name, run))
    found: dict[str, Any] = {
        "case": answer["case"], "kind": concealed["id"], "tier": answer["tier"], "seen": seen,
        "word": "no verdict", "law": "", "library": "", "right": False, "gain": None, "hint": "",
        "hint_right": False,
    }  # fmt: skip
    if result is None:
        return found
    found["word"] = result["verdict"]
    physics = [e["id"] for e in result["effects"] if e.get("kind") != "measurement"]
    found["library"] = ", ".join(physics)
    for law in result.get("discovered", []):
        found["law"] = f"{_where(law)}, {law['shape']}"
        found["right"] = _is_right(law, concealed)
        kept = law.get("kept_out")
        found["gain"] = kept["gain_over_library"] if kept else None
    near = next((note for note in result["unexplained"] if "depends_on" in note), None)
    if near is not None:
        found["hint"] = f"{_where(near)}, {near['reduced_chi_square']:.1f} left"
        found["hint_right"] = _is_right(near, concealed)
    return found


def _of(law: Mapping[str, Any]) -> list[str]:
    """What a law depends on."""
    return [name for name in (law["depends_on"], law.get("depends_on_too")) if name]


def _where(law: Mapping[str, Any]) -> str:
    return f"{law['place']} of {' and '.join(_of(law))}"


def _is_right(law: Mapping[str, Any], concealed: Mapping[str, Any]) -> bool:
    """Place and variables."""
    places = AXLES if law["place"] == "axles" else {SAME.get(law["place"], law["place"])}
    at, _, body = str(law["place"]).partition("_")
    if at == "at":  # a force that has a lever: both
        places = {f"force_{body}", f"moment_{body}"}
    variables = {SAME.get(name, name) for name in _of(law)}
    return places <= {*concealed["places"]} and variables <= {*concealed["variables"]}


def _is_run(name: str, value: Any) -> bool:
    return name.startswith("run") and isinstance(value, dict) and "visibility" in value


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Markdown."""
    lines = [
        "| case | concealed | tier | RMS change over noise | verdict | law found | kept-out gain | "
        "from the library | nearest law | |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in rows:
        gain = "" if r["gain"] is None else f"{100 * r['gain']:.0f} %"
        word = "right" if r["right"] else "weak" if r["seen"] < SEEN else "missed"
        lines.append(
            f"| {r['case']} | {r['kind']} | {r['tier']} | {r['seen']:.0f} | {r['word']} | "
            f"{r['law']} | {gain} | {r['library']} | {r['hint']} | {word} |"
        )
    strong = [r for r in rows if r["seen"] >= SEEN]
    right = sum(r["right"] for r in strong)
    wrong = sum(bool(r["law"]) and not r["right"] for r in rows)
    hints = [r["hint_right"] for r in strong if r["hint"]]
    open_said = sum(not r["right"] and r["word"] == "unexplained" for r in strong)
    return [
        *lines,
        "",
        f"Of {len(strong)} with {SEEN:.0f} or more: right place and variable {right}, said to be "
        f"unexplained {open_said}; laws of another place or variable in all: {wrong}; where none "
        f"is claimed, the nearest law has the right place and variable in {sum(hints)} of "
        f"{len(hints)}.",
    ]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--diagnoses", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    rows = []
    for path in sorted(given.answers.glob("*/answer.json")):
        answer = json.loads(path.read_text())
        verdict = given.diagnoses / answer["case"] / "diagnosis.json"
        rows.append(row(answer, json.loads(verdict.read_text()) if verdict.exists() else None))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text("\n".join([*table(rows), ""]), encoding="utf-8")
    print(given.out.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
