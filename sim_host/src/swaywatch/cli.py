"""``swaywatch COMMAND``: finds the commands, runs one, turns bad input into a message.

Exit code 0: done; 1: the input is at fault (one message on stderr says what and where), or
unexpected internal error (one line says where a report of it is);
2: wrong usage of the command line; 3: done, but the logger says that it lost frames;
130: interrupted.
"""

from __future__ import annotations

import argparse
import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from swaywatch import __version__, commands
from swaywatch.errors import SwaywatchError
from swaywatch.nearest import did_you_mean, nearest
from swaywatch.terminal import crash, output
from swaywatch.terminal.interrupt import INTERRUPTED, ends_at_once


def command_names() -> list[str]:
    """Names of the commands: one for each module of :mod:`swaywatch.commands`."""
    modules = pkgutil.iter_modules(commands.__path__)
    return sorted(info.name for info in modules if not info.name.startswith("_"))


def options_of(parser: argparse.ArgumentParser) -> list[str]:
    """Every option of a parser and of its subcommands."""
    found: list[str] = []
    for action in parser._actions:
        found += action.option_strings
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                found += options_of(inner)
    return found


class _Parser(argparse.ArgumentParser):
    """Says which known word was meant."""

    def error(self, message: str) -> NoReturn:
        words = message.split("unrecognized arguments: ")
        if len(words) == 2:
            near = nearest(words[1].split()[0], options_of(self))
            message += f"; did you mean {near}?" if near else ""
        super().error(message)


class _Version(argparse.Action):
    """``--version`` with that of the C core inside."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        from swaywatch.ecu.core import core_version

        print(f"swaywatch {__version__} (core {core_version()})")
        parser.exit()


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """Parser with the subcommands of all modules, or of module `only` (which starts sooner)."""
    parser = _Parser(
        prog="swaywatch",
        description="How far a car-trailer combination is from yaw instability, and why.",
        epilog="`swaywatch COMMAND --help` explains a command; `swaywatch init RECORDING` writes "
        "the two files that a first analysis needs.",
    )
    parser.add_argument(
        "--version", action=_Version, nargs=0, help="version of the package and of its C core"
    )
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in command_names() if only is None else [only]:
        module = importlib.import_module(f"{commands.__name__}.{name}")
        before = set(subparsers.choices)
        module.add_parser(subparsers)
        for added in set(subparsers.choices) - before:
            output.add_common(subparsers.choices[added], as_json=getattr(module, "HAS_JSON", False))
            subparsers.choices[added].set_defaults(run=module.run)
    return parser


def _unknown(word: str) -> str:
    """The message for a word that is no command."""
    return (
        f"swaywatch: there is no command {word!r}{did_you_mean(word, command_names())}\n"
        f"  commands: {', '.join(command_names())}\n  swaywatch --help explains them"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    names = command_names()
    if words and not words[0].startswith("-") and words[0] not in names:
        print(_unknown(words[0]), file=sys.stderr)
        return 2
    only = words[0] if words and words[0] in names else None
    try:
        with ends_at_once():
            return _run(words, only)
    except KeyboardInterrupt:
        print("\nswaywatch: interrupted", file=sys.stderr)
        return INTERRUPTED


def _run(words: list[str], only: str | None) -> int:
    """Parse and run; every error but an interruption becomes one line."""
    name = f"swaywatch {only or ''}".strip()
    try:
        args = build_parser(only).parse_args(words)
        with output.text_output(args):
            return int(args.run(args))
    except SwaywatchError as error:
        print(f"{name}: {error}", file=sys.stderr)
        if output.verbose and error.__cause__ is not None:
            print(f"  because of {error.__cause__!r}", file=sys.stderr)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # nobody reads any more: no second complaint
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("swaywatch"):
            _crashed(name, words, error)
        else:
            print(f"{name}: {crash.missing_module(error)}", file=sys.stderr)
    except MemoryError:
        print(f"{name}: not enough memory for this input; give fewer or shorter recordings",
              file=sys.stderr)  # fmt: skip
    except Exception as error:
        _crashed(name, words, error)
    return 1


def _crashed(name: str, words: list[str], error: Exception) -> None:
    path = crash.write_report(words, error)
    where = f"a report of it is in {path}" if path else "no report of it could be written"
    text = " ".join(str(error).split())[:200]
    print(
        f"{name}: unexpected internal error ({type(error).__name__}: {text}); "
        f"{where}; please send it to the maintainers of swaywatch",
        file=sys.stderr,
    )


if __name__ == "__main__":
    sys.exit(main())
