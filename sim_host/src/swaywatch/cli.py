"""``swaywatch COMMAND``: finds the commands, runs one, turns bad input into a message.

Exit code 0: done; 1: the input is at fault (one message on stderr says what and where);
2: wrong usage of the command line; 3: done, but the logger says that it lost frames;
130: interrupted.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import sys
from collections.abc import Sequence

from swaywatch import __version__, commands
from swaywatch.errors import SwaywatchError


def build_parser() -> argparse.ArgumentParser:
    """Parser with one subcommand per module of :mod:`swaywatch.commands`."""
    parser = argparse.ArgumentParser(
        prog="swaywatch",
        description="How far is this car-trailer combination from yaw instability, and why.",
    )
    parser.add_argument("--version", action="version", version=f"swaywatch {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for module_info in sorted(pkgutil.iter_modules(commands.__path__), key=lambda info: info.name):
        if module_info.name.startswith("_"):
            continue
        module = importlib.import_module(f"{commands.__name__}.{module_info.name}")
        before = set(subparsers.choices)
        module.add_parser(subparsers)
        for name in set(subparsers.choices) - before:
            subparsers.choices[name].set_defaults(run=module.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    args = build_parser().parse_args(argv)
    try:
        return int(args.run(args))
    except SwaywatchError as error:
        print(f"swaywatch {args.command}: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        sys.stderr.close()
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
