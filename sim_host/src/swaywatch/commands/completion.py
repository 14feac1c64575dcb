"""``swaywatch completion``: commands, options and files by the Tab key."""

from __future__ import annotations

import argparse
from typing import Any

_BASH = """# swaywatch completion bash > ~/.local/share/bash-completion/completions/swaywatch
_swaywatch() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} command=${{COMP_WORDS[1]}} words
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "{commands} --help --version" -- "$word"))
        return
    fi
    case $command in
{cases}
    esac
    case $word in
        -*) COMPREPLY=($(compgen -W "$words" -- "$word")) ;;
        *) compopt -o default -o filenames; COMPREPLY=() ;;
    esac
}}
complete -F _swaywatch swaywatch
"""
_ZSH = """#compdef swaywatch
# swaywatch completion zsh > "${{fpath[1]}}/_swaywatch"
_swaywatch() {{
    local -a commands
    commands=({described})
    if (( CURRENT == 2 )); then _describe command commands; return; fi
    case $words[2] in
{cases}
    esac
}}
_swaywatch "$@"
"""


def add_parser(subparsers: Any) -> None:
    """Add the ``completion`` command."""
    parser = subparsers.add_parser(
        "completion",
        help="script that completes commands and options in bash, zsh or fish",
        description="Print a completion script; its first line shows where to put it.",
    )
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))


def _options() -> dict[str, tuple[str, list[tuple[str, str]]]]:
    """Command -> its help, and its long options with theirs."""
    from swaywatch.cli import build_parser

    parser = build_parser()
    action = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
    return {
        name: (
            helps.get(name, ""),
            [
                (option, (a.help or "").partition(" (default")[0])
                for a in inner._actions
                for option in a.option_strings
                if option.startswith("--")
            ],
        )
        for name, inner in action.choices.items()
    }


def script(shell: str) -> str:
    """The completion script of a shell."""
    known = _options()
    if shell == "bash":
        cases = "\n".join(
            f'        {name}) words="{" ".join(o for o, _ in options)}" ;;'
            for name, (_, options) in known.items()
        )
        return _BASH.format(commands=" ".join(known), cases=cases)
    if shell == "zsh":
        described = " ".join(_single(f"{name}:{text}") for name, (text, _) in known.items())
        cases = "\n".join(
            f"        {name}) _arguments "
            + " ".join(_single(f"{o}[{_plain(text)}]") for o, text in options)
            + " '*:file:_files' ;;"
            for name, (_, options) in known.items()
        )
        return _ZSH.format(described=described, cases=cases)
    lines = ["# swaywatch completion fish > ~/.config/fish/completions/swaywatch.fish"]
    for name, (text, options) in known.items():
        lines.append(f"complete -c swaywatch -n __fish_use_subcommand -a {name} -d {_single(text)}")
        lines += [
            f"complete -c swaywatch -n '__fish_seen_subcommand_from {name}' -l {o[2:]} "
            f"-d {_single(said)}"
            for o, said in options
        ]
    return "\n".join(lines) + "\n"


def _single(text: str) -> str:
    escaped = text.replace("'", "'\\''")
    return f"'{escaped}'"


def _plain(text: str) -> str:
    return text.replace("[", "(").replace("]", ")").replace(":", ",")


def run(args: argparse.Namespace) -> int:
    """Print the script."""
    print(script(args.shell), end="")
    return 0
