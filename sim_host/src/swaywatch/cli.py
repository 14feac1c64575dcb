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


def command_names() -> list[str]:
    """Names of the commands: one for each module of :mod:`swaywatch.commands`."""
    modules = pkgutil.iter_modules(commands.__path__)
    return sorted(info.name for info in modules if not info.name.startswith("_"))


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """Parser with the subcommands of all modules, or of module `only` (which starts sooner)."""
    parser = argparse.ArgumentParser(
        prog="swaywatch",
        description="How far is this car-trailer combination from yaw instability, and why.",
    )
    parser.add_argument("--version", action="version", version=f"swaywatch {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in command_names() if only is None else [only]:
        module = importlib.import_module(f"{commands.__name__}.{name}")
        before = set(subparsers.choices)
        module.add_parser(subparsers)
        for added in set(subparsers.choices) - before:
            subparsers.choices[added].set_defaults(run=module.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    only = words[0] if words and words[0] in command_names() else None
    args = build_parser(only).parse_args(words)
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
