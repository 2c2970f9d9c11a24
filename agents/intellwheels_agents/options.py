"""The options of a mind: text by name, with readers that convert and check.

An option that was given but never read is a typing error of the user, and is refused by name. Names that begin with
a capital letter are not options of the mind: they set fields of the robot document (`robot_document`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from intellwheels_schemas.explain import did_you_mean


class OptionError(ValueError):
    """An option that cannot be used; the text says which option, what was expected and what came."""


class Options(Mapping[str, str]):
    """Options by name, with readers that check them.

    Every reader takes the option's name and, where there is one, the default for an absent option.

    Attributes:
        declared: The range and default of each option that was read, in words, by name.
    """

    def __init__(self, given: Mapping[str, str] | None = None) -> None:
        self._given = dict(given or {})
        self._known: set[str] = set()
        self.declared: dict[str, str] = {}

    def __getitem__(self, name: str) -> str:
        self._known.add(name)
        return self._given[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._given)

    def __len__(self) -> int:
        return len(self._given)

    def __contains__(self, name: object) -> bool:
        self._known.add(str(name))
        return name in self._given

    def text(self, name: str, default: str = "") -> str:
        """Return the option as text."""
        self._declare(name, f"text; default {default or 'none'}")
        return self.get(name, default)

    def number(self, name: str, default: float, low: float = -math.inf, high: float = math.inf) -> float:
        """Return the option as a number in [low, high].

        Raises:
            OptionError: It is not a number, or is out of range.
        """
        expected = "a number" if math.isinf(low) and math.isinf(high) else f"a number in [{low:g}, {high:g}]"
        self._declare(name, f"{expected}; default {default:g}")
        text = self.get(name)
        if text is None:
            return default
        value = _number(text)
        if value is None or not low <= value <= high:
            raise OptionError(f"option {name}: expected {expected}, got {text!r}")
        return value

    def flag(self, name: str, default: bool = False) -> bool:
        """Return the option as a truth value.

        Raises:
            OptionError: It is neither true nor false.
        """
        return self.choice(name, ("true", "false"), "true" if default else "false") == "true"

    def choice(self, name: str, words: tuple[str, ...], default: str) -> str:
        """Return the option as one of `words`.

        Raises:
            OptionError: It is none of them.
        """
        self._declare(name, f"one of {', '.join(words)}; default {default}")
        text = self.get(name, default)
        if text not in words:
            raise OptionError(f"option {name}: expected one of {', '.join(words)}, got {text!r}")
        return text

    def words(self, name: str, expected: str = "names, separated by spaces or commas; default none") -> tuple[str, ...]:
        """Return the option as words separated by spaces or commas.

        Args:
            name: The option.
            expected: What it is, for the help; with its default, or whether it is required.
        """
        self._declare(name, expected)
        return tuple(self.get(name, "").replace(",", " ").split())

    def points(self, name: str) -> tuple[tuple[float, float], ...]:
        """Return the option as points (x, y) in m, written x y x y with spaces or commas between.

        Raises:
            OptionError: A word is not a number, or the last y is missing.
        """
        self._declare(name, 'pairs of coordinates, "x y x y"; default none')
        words = self.words(name)
        numbers = [_number(word) for word in words]
        values = [number for number in numbers if number is not None]
        if len(values) != len(words) or len(values) % 2:
            raise OptionError(f"option {name}: expected numbers in pairs, x y x y, got {self[name]!r}")
        return tuple(zip(values[::2], values[1::2], strict=True))

    def _declare(self, name: str, text: str) -> None:
        self.declared.setdefault(name, text)

    def check_all_read(self) -> None:
        """Refuse options that no reader asked for.

        Raises:
            OptionError: There is such an option.
        """
        unknown = sorted(set(self._given) - self._known)
        if unknown:
            known = ", ".join(sorted(self._known)) or "none"
            hint = did_you_mean(unknown[0], self._known)
            text = f"option {unknown[0]}: expected an option of this mind ({known}), got {unknown[0]!r}{hint}"
            raise OptionError(text)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
