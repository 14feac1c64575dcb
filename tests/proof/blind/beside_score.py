"""Table of a set of `beside`: what was concealed, what was named, what is inseparable.

``python beside_score.py --answers DIR --diagnoses DIR --out FILE.md``. An effect
counts as named where its id is claimed, and as inseparable where it is among a claim's equivalents.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from information import NAMEABLE
from score import load

#: Other kinds of damper are a fade or an asymmetry, in the words of the library.
SAME = {"damper_kind": ("damper_fade", "damper_asymmetry")}


def row(
    answer: Mapping[str, Any], result: Mapping[str, Any] | None, limits: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """One case: its effects, each with a word, and what else was claimed.

    `limits`: of each effect, as `case_limits.py` writes them; none: none is known to be above it.
    """
    claims = [] if result is None else list(result["effects"])
    said, used = [], set()
    for number, effect in enumerate(answer["effects"]):
        ids = SAME.get(effect["id"], (effect["id"],))
        name = effect.get("kind", effect["id"])
        seen = bool(limits) and limits[number]["name"] >= NAMEABLE
        own = [i for i, claim in enumerate(claims) if claim["id"] in ids]
        like = [i for i, claim in enumerate(claims) if _alike(claim, ids)]
        used |= {*own[:1], *(like[:1] if not own else ())}
        word = "named" if own else "inseparable" if like else "missed"
        place = effect.get("axle") or effect.get("channel") or effect.get("body") or ""
        said.append({"name": f"{name} {place}".strip(), "word": word, "above": seen})
    others = [c["id"] for i, c in enumerate(claims) if i not in used]
    verdict = "no verdict" if result is None else result["verdict"]
    return {"case": answer["case"], "effects": said, "others": others, "verdict": verdict}


def _alike(claim: Mapping[str, Any], ids: tuple[str, ...]) -> bool:
    names = [str(name).partition(":")[0] for name in claim.get("equivalent", [])]
    return bool(set(names) & set(ids))


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Markdown."""
    lines = ["| case | concealed | named | claimed beside it | verdict |", "|---|---|---|---|---|"]
    for r in rows:
        names = " + ".join(e["name"] + ("" if e["above"] else " (weak)") for e in r["effects"])
        words = " + ".join(e["word"] for e in r["effects"])
        lines.append(
            f"| {r['case']} | {names} | {words} | {', '.join(r['others'])} | {r['verdict']} |"
        )
    strong = [r for r in rows if all(e["above"] for e in r["effects"])]
    both = sum(all(e["word"] != "missed" for e in r["effects"]) for r in strong)
    every = sum(all(e["word"] != "missed" for e in r["effects"]) for r in rows)
    lines += [
        "",
        f"All named or said to be inseparable: {both} of {len(strong)} above the limits of "
        f"detection, {every} of {len(rows)} in all; something else claimed in "
        f"{sum(bool(r['others']) for r in rows)}.",
    ]
    return lines


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--diagnoses", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    rows = []
    for path in sorted(given.answers.glob("*/answer.json")):
        answer = load(path) or {}
        limits = (load(path.parent / "limit.json") or {}).get("limits", [])
        rows.append(row(answer, load(given.diagnoses / answer["case"] / "diagnosis.json"), limits))
    lines = table(rows)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
