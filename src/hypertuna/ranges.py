"""Check numbers against ranges, and names against choices: `POSITIVE.check(speed, "speed", "give it in m/s")`."""

import math
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from hypertuna.errors import InputError, did_you_mean, shown


@dataclass(frozen=True, kw_only=True)
class Range:
    """Finite numbers within limits; `above` and `below` exclude the limit itself; the error names the `unit`."""

    min: float | None = None
    max: float | None = None
    above: float | None = None
    below: float | None = None
    unit: str = ""

    def __contains__(self, number: float) -> bool:
        return (
            math.isfinite(number)
            and (self.min is None or number >= self.min)
            and (self.max is None or number <= self.max)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
        )

    @property
    def rule(self) -> str:
        """The range as the verb phrase of an error."""
        if self.min == 0 and self.max is self.below is None:
            return "must not be negative"
        if self.min is not None and self.max is not None:
            return f"must be from {self.min:g} to {self.max:g} {self.unit}".rstrip()
        limits = {"at least": self.min, "greater than": self.above, "at most": self.max, "less than": self.below}
        phrases = [f"{words} {limit:g}" for words, limit in limits.items() if limit is not None]
        return f"must be {' and '.join(phrases) or 'a finite number'} {self.unit}".rstrip()

    def check(self, value: Any, key: str, fix: str | None = None, *, file: str | None = None) -> float:
        """Return a value as a float if it is in the range, else raise InputError; texts and booleans are refused."""
        try:
            number = math.nan if isinstance(value, str | bytes | bool) else float(value)
        except (TypeError, ValueError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise InputError("must be a finite number", file=file, key=key, value=shown(value), fix=fix)
        if number not in self:
            raise InputError(self.rule, file=file, key=key, value=f"{number:g}", fix=fix)
        return number


@dataclass(frozen=True, kw_only=True)
class Whole:
    """Whole numbers from `min` to `max`."""

    min: int | None = None
    max: int | None = None

    def __contains__(self, number: int) -> bool:
        return (self.min is None or number >= self.min) and (self.max is None or number <= self.max)

    @property
    def rule(self) -> str:
        """The range as the verb phrase of an error."""
        if self.min is not None and self.max is not None:
            return f"must be from {self.min} to {self.max}"
        if self.min is not None:
            return f"must be at least {self.min}"
        return "must be a whole number" if self.max is None else f"must be at most {self.max}"

    def check(self, value: Any, key: str, fix: str | None = None, *, file: str | None = None) -> int:
        """Return a value as an int if it is in the range, otherwise raise InputError; 5.0 and booleans are refused."""
        try:
            number = operator.index(value)
        except TypeError:
            number = None
        if number is None or isinstance(value, bool):
            raise InputError("must be a whole number", file=file, key=key, value=shown(value), fix=fix)
        if number not in self:
            raise InputError(self.rule, file=file, key=key, value=shown(number), fix=fix)
        return number


FINITE = Range()
CELL = Range(min=-1e12, max=1e12)  # numbers in tables of measurements, in any unit
POSITIVE = Range(above=0)
NOT_NEGATIVE = Range(min=0)
FRACTION = Range(min=0, max=1)
WHOLE = Whole()
POSITIVE_WHOLE = Whole(min=1)


def check_choice(word: str, words: Iterable[str], key: str) -> str:
    """Check that a word is one of a few; the error lists all of them: "must be water, air or oil"."""
    words = list(words)
    if word not in words:
        fix = did_you_mean(str(word), words)
        choice = " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
        raise InputError(f"must be {choice}", key=key, value=shown(word), fix=fix)
    return word


def check_name(name: str, names: Iterable[str], key: str, kind: str, fix: str = "") -> str:
    """Check that a name is one of `names`; the error suggests the nearest one: "must be a known frame"."""
    names = list(names)
    if name not in names:
        fix = fix or did_you_mean(str(name), names)
        raise InputError(f"must be a known {kind}", key=key, value=shown(name), fix=fix)
    return name
