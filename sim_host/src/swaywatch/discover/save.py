"""Writing a discovered law as an effect file, and reading such files."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from swaywatch.discover.effect import effect_of
from swaywatch.discover.law import PERIODIC, law_of
from swaywatch.effects.effect import Effect
from swaywatch.errors import SwaywatchError

_FILE = '''"""{text}

Identified by `swaywatch diagnose` from {runs}. Law: {law}
{numbers}
Rename it as you like; `swaywatch diagnose --physics {file}` then includes it.
"""

from swaywatch.discover.save import named

EFFECTS = [
    named(
        "{id}",
        "{spec}",
        starts={starts},
        source="{source}",
    )
]
'''


ALONG_THE_ROAD = (
    "what comes and goes along the road has a phase of its own in every run, which an effect of "
    "a file cannot know; a diagnosis looks for it by itself"
)


def named(id_: str, spec: str, starts: Mapping[str, float], source: str = "a recording") -> Effect:
    """A law under a name, which makes it an effect like those of the library.

    Parameters
    ----------
    id_
        Its name in diagnosis.json.
    spec
        The law as one string, `spec` in `discovered` of a diagnosis.json.
    starts
        Initial values of a fit, by parameter.
    """
    law = law_of(spec)
    if law.response == PERIODIC:
        raise SwaywatchError(f"{id_}: {ALONG_THE_ROAD}")
    effect = effect_of(law)
    unknown = set(starts) - {p.name for p in effect.parameters}
    if unknown:
        names = ", ".join(p.name for p in effect.parameters)
        raise SwaywatchError(f"{id_}: {spec} has no {', '.join(sorted(unknown))}; it has {names}")
    parameters = tuple(
        replace(p, starts=(float(starts.get(p.name, p.starts[0])),)) for p in effect.parameters
    )
    return replace(effect, id=id_, parameters=parameters, source=source)


def save_law(result: Mapping[str, Any], path: Path) -> bool:
    """Write the law of a diagnosis.json as an effect file; False where there is none."""
    laws = result.get("discovered") or []
    if not laws:
        return False
    law = laws[0]
    if law_of(law["spec"]).response == PERIODIC:
        raise SwaywatchError(f"{path}: not written: {ALONG_THE_ROAD}")
    numbers = "\n".join(
        f"{name} = {row['value']:.6g} {row['unit']} ({row['low']:.4g} to {row['high']:.4g})"
        for name, row in law["parameters"].items()
    )
    runs = ", ".join(Path(name).name for name in result["inputs"]["recordings"])
    text = _FILE.format(
        text=f"{law['text'][:1].upper()}{law['text'][1:]}.",
        runs=runs,
        law=law["law"],
        numbers=numbers,
        file=path.name,
        id=path.stem,
        spec=law["spec"],
        starts={
            p.name: float(f"{law['parameters'][p.name]['value']:.6g}")
            for p in effect_of(law_of(law["spec"])).parameters
            if p.name in law["parameters"]
        },
        source=f"found in {runs}",
    )
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SwaywatchError(f"{path}: cannot be written ({error.strerror})") from error
    return True


def read_physics(paths: Sequence[Path]) -> list[Effect]:
    """Effects from the user's own files, which are executed as Python."""
    found: list[Effect] = []
    for path in paths:
        if not path.is_file():
            raise SwaywatchError(f"{path}: no such file")
        spec = importlib.util.spec_from_file_location(f"_own_physics_{len(found)}", path)
        if spec is None or spec.loader is None:
            raise SwaywatchError(f"{path}: not a Python file; its name has to end in .py")
        module = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            moved = isinstance(error, ImportError) and (error.name or "").startswith("swaywatch")
            hint = (
                "; the file is for another version of swaywatch, in this one Effect and Parameter "
                "are in swaywatch.effects.effect"
            )
            raise SwaywatchError(
                f"{path}: {type(error).__name__}: {error}{hint if moved else ''}"
            ) from error
        effects = getattr(module, "EFFECTS", None)
        if not isinstance(effects, list) or not all(isinstance(e, Effect) for e in effects):
            raise SwaywatchError(f"{path}: has no list EFFECTS of swaywatch's Effect objects")
        found += effects
    return found
