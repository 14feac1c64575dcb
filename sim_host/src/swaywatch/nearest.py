"""The known name that a misspelt one was probably meant to be; every message asks here."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

CUTOFF = 0.6
"""Least similarity (twice the letters in common, over all letters), 0 to 1."""


def nearest(word: object, known: Iterable[str]) -> str | None:
    """The most similar of the `known` names, or None if none is similar."""
    found = difflib.get_close_matches(str(word), list(known), 1, CUTOFF)
    return found[0] if found else None


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """End of a message about an unknown `word`: ``; did you mean 'mass'?``, or nothing."""
    found = nearest(word, known)
    return "" if found is None else f"; did you mean {found!r}?"


def with_known(word: object, known: Iterable[str]) -> str:
    """As :func:`did_you_mean`, and the list of what is known."""
    names = list(known)
    hint = did_you_mean(word, names)
    return f"{hint} Known: {', '.join(names)}" if hint else f"; known: {', '.join(names)}"
