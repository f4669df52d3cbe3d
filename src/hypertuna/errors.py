"""Errors for bad input: each is one sentence with file, key, rule, value and fix; a file may have several."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable, Sequence
from pathlib import PurePath

CONTROL = ("Cc", "Cf", "Cs", "Zl", "Zp")  # Unicode categories of control characters, which terminals would obey
MAX_LISTED = 15  # largest number of a file's mistakes that an error lists
MAX_LENGTH = 300  # largest length of a name in an error [characters]
PLAIN = (str, bytes, int, float, complex, list, tuple, set, dict, PurePath, type(None))  # types written out in errors


class InputError(ValueError):
    """Bad input, described in one sentence.

    Parameters
    ----------
    rule : str
        The rule as the verb phrase of the sentence: ``"must be greater than 0"``.
    file : str, optional
        The file that holds the value.
    key : str, optional
        The key as written in the file, with indices from 0: ``"links.mass_kg[3]"``.
    value : str, optional
        The present value.
    fix : str, optional
        The correction.

    Examples
    --------
    >>> print(InputError("must be greater than 0", key="links.mass_kg[3]", value="-0.1", fix="give the mass in kg"))
    links.mass_kg[3] must be greater than 0, but is -0.1: give the mass in kg.
    """

    def __init__(
        self,
        rule: str,
        *,
        file: str | None = None,
        key: str | None = None,
        value: str | None = None,
        fix: str | None = None,
    ) -> None:
        super().__init__(rule)
        self.file, self.key, self.rule, self.value, self.fix = file, key, rule, value, fix

    def __str__(self) -> str:
        subject = ": ".join(_short(name) for name in (self.file, self.key) if name)
        value = f", but is {_short(self.value)}" if self.value else ""
        fix = f": {self.fix}" if self.fix else ""
        sentence = escaped(f"{subject} {self.rule}{value}{fix}".lstrip(), "\n")
        return sentence if sentence.endswith("?") else f"{sentence}."


class DamageWarning(UserWarning):
    """Warning about a damaged part of a file, without which the work goes on."""


class InputErrors(InputError):
    """Several errors of one file, of which the first gives key, rule, value and fix.

    paste: text that corrects the file; whole: whether it replaces the whole file.
    """

    def __init__(self, errors: Sequence[InputError], paste: str = "", whole: bool = False) -> None:
        first = errors[0]
        super().__init__(first.rule, file=first.file, key=first.key, value=first.value, fix=first.fix)
        self.errors, self.paste, self.whole = tuple(errors), paste, whole

    def __reduce__(self) -> tuple[type[InputErrors], tuple[tuple[InputError, ...], str, bool]]:
        return InputErrors, (self.errors, self.paste, self.whole)

    def __str__(self) -> str:
        sentences = [_without_file(error) for error in self.errors]
        if len(sentences) == 1:
            text = str(self.errors[0])
        else:
            listed = [f"  {number}. {sentence}" for number, sentence in enumerate(sentences[:MAX_LISTED], 1)]
            more_count = len(sentences) - MAX_LISTED
            more = [f"  and {more_count} more, which often follow from these"] * (more_count > 0)
            text = "\n".join([f"{self.file or 'the file'} has {len(sentences)} mistakes:", *listed, *more])
        where = " in place of the whole file, as `hypertuna robot new` writes it" if self.whole else ""
        return f"{text}\nTo paste{where}, with example values to replace:\n\n{self.paste}" if self.paste else text


def _without_file(error: InputError) -> str:
    """Return the sentence of an error without the file."""
    return str(InputError(error.rule, key=error.key, value=error.value, fix=error.fix))


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the fix for an unknown name: the nearest known name, or else the first twelve known names."""
    names = [_short(name) for name in known]
    nearest = difflib.get_close_matches(word[:MAX_LENGTH], names, n=1)
    if nearest:
        return f"did you mean {nearest[0]}?"
    more = f" and {len(names) - 12} more" if len(names) > 12 else ""
    return f"use one of {', '.join(names[:12])}{more}" if names else "remove it"


def escaped(text: str, keep: str = "") -> str:
    """Escape control characters, except those in `keep`, as in JSON, since a terminal would obey them."""
    if text.isprintable():
        return text
    if "\n" in keep:  # line by line, since most lines need no escaping
        return "\n".join(escaped(line, keep.replace("\n", "")) for line in text.split("\n"))
    return "".join(c if c in keep or unicodedata.category(c) not in CONTROL else _code(c) for c in text)


def _code(character: str) -> str:
    """Return a character as the escaped UTF-16 code units of JSON."""
    digits = character.encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{digits[k : k + 4]}" for k in range(0, len(digits), 4))


def _short(text: str) -> str:
    """Return a name or a value on one line; the middle of a very long one is left out."""
    return escaped(text if len(text) <= MAX_LENGTH else f"{text[: MAX_LENGTH // 2]}...{text[-MAX_LENGTH // 2 :]}")


def _plain(value: object) -> bool:
    """Return whether errors write out a value: a number, a text, a list of these, or an array."""
    return isinstance(value, PLAIN) or hasattr(value, "dtype")


def with_article(kind: str) -> str:
    """Return the name of a type with its article: "a Swim", "an Optimum", "Gaits"."""
    return kind if kind.endswith("s") else f"{'an' if kind[:1] in tuple('AEIO') else 'a'} {kind}"


def shown(value: object) -> str:
    """Return a value as text for an error: plain values on one line of 60 characters, others as their type."""
    if isinstance(value, list | tuple | set) and not all(map(_plain, value)):
        kinds = dict.fromkeys(type(part).__name__ for part in value)
        return f"a {type(value).__name__} of {', '.join(kinds)}"
    if not _plain(value):
        return with_article(type(value).__name__)
    try:
        text = "true" if value is True else "false" if value is False else repr(value)
    except ValueError:  # Python does not write whole numbers with more than 4300 digits
        text = "a number of more than 4300 digits"
    text = " ".join(text.split("\n"))
    return text if len(text) <= 60 else f"{text[:57]}..."
