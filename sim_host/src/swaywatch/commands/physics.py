"""``swaywatch physics``: what the diagnosis can name and the simulator can switch on."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any

from swaywatch.errors import ScenarioError
from swaywatch.nearest import with_known
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``physics`` command."""
    parser = subparsers.add_parser(
        "physics",
        help="list everything that a diagnosis can identify and a scenario can switch on",
        description="Every id that `swaywatch diagnose` can report (missing physics, faults of "
        "sensors, wrong values) and that a scenario of `swaywatch simulate` can switch on: "
        "equation, source, where each enters, parameters with bounds and units.",
    )
    parser.add_argument("id", nargs="?", help="show this entry in full")


def known() -> dict[str, dict[str, Any]]:
    """Every id with its title, equation, source, and who knows it.

    Returns
    -------
    dict
        Keys of an entry: ``title``, ``equation``, ``source``, ``reported`` (by diagnose),
        ``simulated`` (by simulate), ``parameters`` (name, unit).
    """
    from swaywatch.checks.sensor_faults import EQUATIONS, TITLES
    from swaywatch.diagnose.car_alone.effects import effects as car_effects
    from swaywatch.effects.effect import library
    from swaywatch.models.physics import MODULES
    from swaywatch.roles import CHANNELS

    found: dict[str, dict[str, Any]] = {}

    def entry(name: str, kind: str, title: str) -> dict[str, Any]:
        return found.setdefault(
            name,
            {"title": title, "kind": kind, "equation": "", "source": "", "reported": False,
             "simulated": False, "parameters": []},
        )  # fmt: skip

    for effect in library():
        row = entry(effect.id, effect.kind, effect.title)
        row["reported"], row["equation"], row["source"] = True, effect.equation, effect.source
        row["parameters"] = [{"name": p.name, "unit": p.unit} for p in effect.parameters]
    for alone in car_effects(tuple(CHANNELS)):
        row = entry(alone.id, alone.kind, alone.title)
        row["reported"] = True
        row["equation"] = row["equation"] or alone.equation
        row["source"] = row["source"] or alone.source
    for name, equation in EQUATIONS.items():
        row = entry(name, "measurement", TITLES[name])
        row["reported"], row["equation"] = True, equation
        row["source"] = row["source"] or "fault of the measurement"
    for module in MODULES.values():
        row = entry(module.id, "physics", module.title)
        row["simulated"], row["title"] = True, module.title
        row["equation"], row["source"] = module.equation, module.source
    return dict(sorted(found.items()))


def _who(row: dict[str, Any]) -> str:
    both = (("reported", "diagnose"), ("simulated", "simulate"))
    return ", ".join(word for key, word in both if row[key])


def run(args: argparse.Namespace) -> int:
    """Print the list, or one entry."""
    rows = known()
    if args.id is None:
        output.result(args, rows)
        width = max(map(len, rows))
        for name, row in rows.items():
            print(f"{name:{width}s} {_who(row):18s} {row['title']}")
        return 0
    if args.id not in rows:
        raise ScenarioError(f"no effect {args.id!r}{with_known(args.id, rows)}")
    output.result(args, rows[args.id])
    print(_full(args.id, rows[args.id]))
    return 0


def _full(name: str, row: dict[str, Any]) -> str:
    """One entry, with what a scenario can set of it."""
    from swaywatch.models.physics import MODULES

    module = MODULES.get(name)
    lines = [name, f"  {row['title']}", f"  known to: {_who(row)}"]
    texts = [("equation", row["equation"]), ("source", row["source"])]
    if module is not None:
        texts.append(("enters", module.enters))
    for head, text in texts:
        lines += textwrap.wrap(f"{head}: {text}", 96, initial_indent="  ", subsequent_indent="    ")
    if module is None:
        lines += [f"  {p['name']}: {p['unit']}" for p in row["parameters"]]
        return "\n".join(lines)
    for key, choices in module.options.items():
        lines.append(f"  {key} = {' | '.join(choices)}")
    for p in module.parameters:
        span = f"{p.low:g} to {p.high:g} {p.unit}, default {p.start:g}"
        note = f"; {p.meaning}" if p.meaning else ""
        lines.append(f"  {p.name}: {span}{' (per window)' if p.windowed else ''}{note}")
    return "\n".join(lines)
