"""Reading of a table with checks: every key known, every number in its range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from swaywatch.errors import ScenarioError
from swaywatch.nearest import did_you_mean, with_known


class Table:
    """One table of a scenario; :meth:`done` refuses keys that nobody asked for."""

    def __init__(self, content: Any, place: str) -> None:
        if not isinstance(content, Mapping):
            raise ScenarioError(f"{place} must be a table")
        self.place = place
        self._content = dict(content)
        self._used: set[str] = set()

    def has(self, key: str) -> bool:
        """Is the key there."""
        return key in self._content

    def raw(self, key: str, default: Any = None) -> Any:
        """A value as it is."""
        self._used.add(key)
        return self._content.get(key, default)

    def number(
        self, key: str, low: float, high: float, unit: str, default: float | None = None
    ) -> float:
        """A number within its range."""
        value = self.raw(key, default)
        if value is None:
            raise ScenarioError(
                f"{self.place}: {key} is missing; expected {low:g} to {high:g} {unit}"
            )
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ScenarioError(f"{self.place}: {key} = {value!r} must be a number in {unit}")
        if not low <= value <= high:
            raise ScenarioError(
                f"{self.place}: {key} = {value:g} {unit} is out of range; expected {low:g} to "
                f"{high:g} {unit}"
            )
        return float(value)

    def word(self, key: str, choices: Sequence[str], default: str | None = None) -> str:
        """One of a few words."""
        value = self.raw(key, default)
        if value not in choices:
            raise ScenarioError(
                f"{self.place}: {key} = {value!r}; expected one of: {', '.join(choices)}"
                + did_you_mean(value, choices)
            )
        return str(value)

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.raw(key, default)
        if not isinstance(value, bool):
            raise ScenarioError(f"{self.place}: {key} = {value!r} must be true or false")
        return value

    def table(self, key: str) -> Table:
        """A table inside; empty if it is not there."""
        return Table(self.raw(key, {}), f"{self.place} [{key}]")

    def tables(self, key: str) -> list[Table]:
        """An array of tables inside; empty if it is not there."""
        value = self.raw(key, [])
        if not isinstance(value, list):
            raise ScenarioError(f"{self.place}: {key} must be an array of tables, [[{key}]]")
        return [Table(item, f"{self.place} [[{key}]] {n + 1}") for n, item in enumerate(value)]

    def keys(self) -> list[str]:
        """The keys that are there."""
        return list(self._content)

    def rest(self) -> dict[str, Any]:
        """Everything that nobody asked for yet."""
        left = {key: value for key, value in self._content.items() if key not in self._used}
        self._used |= set(left)
        return left

    def done(self) -> None:
        """Refuse unknown keys.

        Raises
        ------
        ScenarioError
            Names the key and those that would be right.
        """
        left = sorted(set(self._content) - self._used)
        if left:
            hint = with_known(left[0], sorted(self._used))
            raise ScenarioError(f"{self.place}: unknown key {left[0]!r}{hint}")
