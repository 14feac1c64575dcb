"""`discovered` of diagnosis.json, and the verdict that contains a law."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from swaywatch.diagnose.evidence.evidence import explained
from swaywatch.diagnose.evidence.search import reduced_chi_square
from swaywatch.diagnose.evidence.verdict import SUREST, Verdict
from swaywatch.diagnose.fit.holdout import typical
from swaywatch.discover.effect import ID
from swaywatch.discover.find import Discovery
from swaywatch.discover.inputs import missing_inputs
from swaywatch.discover.law import BODIES, MOTIONS, PERIODIC, PLACES, Law
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.discover.way import DISTANCE

NAMED_BESIDE = 0.9  # confidence in a library effect that a law is claimed beside


def with_law(verdict: Verdict, found: Discovery) -> Verdict:
    """The verdict with the law in the model, and the library effects that stay beside it."""
    known = dict(zip((t.effect.name for t in verdict.fit.terms), verdict.confidence, strict=False))
    names = [t.effect.name for t in found.fit.terms]
    # the law is ahead of the best of the library, also where that was not claimed
    ahead = max([verdict.evidence, *(e for _, e in verdict.candidates)]) + found.evidence
    return replace(
        verdict,
        word="missing_physics" if explained(found.base, found.fit) else "unexplained",
        fit=found.fit,
        baseline=found.base,
        problem=found.search.problem,
        equivalents=[[] for _ in names],
        confidence=[min(known.get(n, NAMED_BESIDE), SUREST) for n in names],
        noise=found.search.noise,
        evidence=ahead,
        candidates=[(" + ".join(names), ahead), *verdict.candidates],
        hidden=[],
        notes=[],
    )


def take_law(result: dict[str, Any], found: Discovery | None) -> None:
    """Move the law of a diagnosis.json from its effects, the library's, to `discovered`."""
    own = [e for e in result["effects"] if e["id"] == ID]
    result["effects"] = [e for e in result["effects"] if e["id"] != ID]
    result["discovered"] = [entry(found, e["parameters"], e["fit"]) for e in own if found]


def location(law: Law) -> str:
    """Where the law acts, in words."""
    if law.motion == "turn":
        return f"yaw moment in the {law.place}"
    if law.place in BODIES:
        return f"side force in the {law.place}"
    if law.place == "tyres":
        return "yaw moment of all tyres"
    return PLACES[law.place].words


def variables(law: Law) -> list[str]:
    """Its variables, in words."""
    if law.motion == "turn":
        return [f"yaw acceleration of the {law.place}", "its own angle and rate"]
    if law.slides:
        return [f"lateral acceleration of the {law.place}", "its own rate"]
    if law.swings:
        return [f"lateral acceleration of the {law.place}", "its own displacement and rate"]
    found = ["tyre side force"] if law.motion == "side_force" else []
    found = found or [
        MOTIONS[name].words for name in filter(None, (law.motion, law.second, law.by))
    ]
    if law.response == PERIODIC and law.motion != DISTANCE:
        found = [*found, MOTIONS[DISTANCE].words]
    return [*found, "speed"] if law.power else found


def entry(found: Discovery, parameters: dict[str, Any], fit: dict[str, Any]) -> dict[str, Any]:
    """One entry of `discovered`.

    Parameters
    ----------
    parameters
        Values of the law with intervals, as `describe` returns them.
    fit
        Scores of the complete model.
    """
    law, term = found.law, found.term
    for p in term.effect.parameters:
        parameters[p.name]["unit"] = p.unit
    if "limit" in parameters:
        per = f" per {MOTIONS[law.times].unit}" if law.times else ""
        parameters["limit"]["unit"] = PLACES[law.place].unit + per
    main = term.values[0]
    before, after = reduced_chi_square(found.base), reduced_chi_square(found.fit)
    kept = typical(found.kept_out) if found.kept_out else None
    error = float(parameters[term.effect.parameters[0].name]["standard_error"])
    return {
        "location": location(law),
        "place": law.place,
        "variables": variables(law),
        "depends_on": law.motion,
        "depends_on_too": law.second or law.by,
        "shape": law.shape,
        "power_of_speed": law.power,
        "law": term.effect.equation,
        "spec": law.spec,
        "text": sentence(law, parameters),
        "perhaps": suggestion(law, main),
        "energy": energy(law, main),
        "parameters": parameters,
        "fit": fit,
        "standard_errors": abs(main) / max(error, 1e-12),
        "share_explained": 1.0 - max(after - 1.0, 0.0) / max(before - 1.0, 1e-9),
        "reduced_chi_square": {
            "calibrated": before, "library": reduced_chi_square(found.library), "with_law": after,
        },
        "log_bayes_factor_to_library": found.evidence,
        "library_would_say": [t.effect.name for t in found.library.terms],
        "beside": [t.effect.name for t in found.fit.terms if t.effect.id != ID],
        "kept_out": None if kept is None else {
            "calibrated_nrmse": kept[0],
            "library_nrmse": kept[1],
            "with_law_nrmse": kept[2],
            "gain_over_library": 1.0 - kept[2] / kept[1],
            "log_times_likelier_than_library": found.likelier,
            "runs": [list(row) for row in found.kept_out],
        },
        "equivalent": [
            {"place": other.place, "depends_on": other.motion, "log_bayes_factor": behind}
            for other, behind in found.others
        ],
        "input": missing_inputs(found),
    }  # fmt: skip
