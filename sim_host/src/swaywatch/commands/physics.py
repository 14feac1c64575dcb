"""``swaywatch physics``: the effects that the simulator and the diagnosis know."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any

from swaywatch.errors import ScenarioError


def add_parser(subparsers: Any) -> None:
    """Add the ``physics`` command."""
    parser = subparsers.add_parser(
        "physics",
        help="list the physical effects a scenario can switch on",
        description="The physics modules of the simulator: equation, source, where each enters, "
        "parameters with bounds and units.",
    )
    parser.add_argument("id", nargs="?", help="one effect, in full")


def run(args: argparse.Namespace) -> int:
    """Print the list, or one effect."""
    from swaywatch.models.physics import MODULES, Module

    def full(module: Module) -> str:
        lines = [module.id, f"  {module.title}"]
        for head, text in (
            ("equation", module.equation), ("source", module.source), ("enters", module.enters)
        ):  # fmt: skip
            lines += textwrap.wrap(
                f"{head}: {text}", 96, initial_indent="  ", subsequent_indent="    "
            )
        for name, choices in module.options.items():
            lines.append(f"  {name} = {' | '.join(choices)}")
        for p in module.parameters:
            span = f"{p.low:g} to {p.high:g} {p.unit}, default {p.start:g}"
            note = f"; {p.meaning}" if p.meaning else ""
            lines.append(f"  {p.name}: {span}{' (per window)' if p.windowed else ''}{note}")
        return "\n".join(lines)

    if args.id is None:
        for module in MODULES.values():
            print(f"{module.id:24s} {module.title}")
        return 0
    if args.id not in MODULES:
        raise ScenarioError(f"no effect {args.id!r}; known: {', '.join(MODULES)}")
    print(full(MODULES[args.id]))
    return 0
