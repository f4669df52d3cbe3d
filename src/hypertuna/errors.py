"""Bad input: one error, one sentence, with the file, the key, the rule, the value and the fix."""

from __future__ import annotations

import difflib
import math
import operator
import re
import types
from collections.abc import Iterable, Mapping
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

Place = tuple[int | str, ...]  # where a value stands in a document: keys and indices, outermost first

__all__ = [
    "InputError",
    "Place",
    "did_you_mean",
    "field_at",
    "finite",
    "nested_model",
    "shown",
    "translate",
    "unit_of",
    "whole",
    "written",
]


class InputError(ValueError):
    """Input that cannot be used, told in one sentence.

    Parameters
    ----------
    rule : str
        What must hold, as the verb phrase of the sentence: ``"must be greater than 0"``.
    file : str, optional
        The file that holds the value.
    key : str, optional
        The key as written in the file, with its index counted from 0: ``"links.mass_kg[3]"``.
    value : str, optional
        What stands there instead.
    fix : str, optional
        What to do about it.

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
        subject = ": ".join(name for name in (self.file, self.key) if name)
        value = f", but is {self.value}" if self.value else ""
        fix = f": {self.fix}" if self.fix else ""
        sentence = f"{subject} {self.rule}{value}{fix}".lstrip()
        return sentence if sentence.endswith("?") else f"{sentence}."


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the fix for a name that is not known: the nearest known name, or all of them.

    Parameters
    ----------
    word : str
        The name as given.
    known : iterable of str
        The names that exist.

    Returns
    -------
    str
        ``"did you mean ...?"`` or ``"use one of ..."``.
    """
    names = list(known)
    near = difflib.get_close_matches(word, names, n=1)
    if near:
        return f"did you mean {near[0]}?"
    return f"use one of {', '.join(names[:12])}{', ...' * (len(names) > 12)}" if names else "remove it"


def shown(value: object) -> str:
    """Return a value as it stands in an error, shortened to one line of 60 characters."""
    try:
        text = "true" if value is True else "false" if value is False else repr(value)
    except ValueError:  # Python writes whole numbers of up to 4300 digits
        text = "a number of more than 4300 digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def finite(value: Any, key: str, fix: str) -> float:
    """Return a finite number, or say that the argument `key` is none: text, true and false are not."""
    try:
        number = math.nan if isinstance(value, str | bytes | bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError("must be a finite number", key=key, value=shown(value), fix=fix)
    return number


def whole(value: Any, key: str, fix: str) -> int:
    """Return a whole number, or say that the argument `key` is none: 5.0 is not, nor are true and false."""
    try:
        return operator.index("" if isinstance(value, bool) else value)  # type: ignore[arg-type]
    except TypeError:
        raise InputError("must be a whole number", key=key, value=shown(value), fix=fix) from None


def nested_model(annotation: Any) -> type[BaseModel] | None:
    """Return the pydantic model inside an annotation such as ``tuple[Model, ...]`` or ``Model | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (nested_model(part) for part in get_args(annotation))
    return next((model for model in found if model is not None), None)


def field_at(model: type[BaseModel] | None, place: Place) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """Find the field that a place in a document leads to.

    Parameters
    ----------
    model : type of BaseModel
        The schema of the whole document.
    place : tuple of int and str
        Keys and indices, outermost first.

    Returns
    -------
    model : type of BaseModel or None
        The schema of the table at that place, None if there is no table.
    field : FieldInfo or None
        The field itself, None for the whole document and for unknown places.
    """
    field: FieldInfo | None = None
    named = False  # inside a table of named entries, such as [gaits.NAME]: the next part is a name
    for part in place:
        if isinstance(part, int):
            continue
        if named or model is None:
            named = False
            continue
        field = next((known for known in model.model_fields.values() if known.alias == part), None)
        if field is None:
            return None, None
        model, named = nested_model(field.annotation), _is_table(field.annotation)
    return model, field


def unit_of(field: FieldInfo | None) -> str:
    """Return the unit of a field, empty if it has none."""
    extra = field.json_schema_extra if field else None
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def translate(
    error: ValidationError, document: Mapping[str, Any], model: type[BaseModel], file: str | None
) -> InputError:
    """Turn pydantic's report on a document into one InputError.

    Parameters
    ----------
    error : pydantic.ValidationError
        What pydantic found. An unknown key is told first: a misspelled key is also a missing one.
    document : mapping
        The document as read, for the value at the place of the error.
    model : type of BaseModel
        The schema; descriptions and units of its fields make the fix.
    file : str or None
        Where the document came from.

    Returns
    -------
    InputError
        The first error, with the key as written in the file.
    """
    problems = error.errors(include_url=False)
    first = next((p for p in problems if p["type"] == "extra_forbidden"), problems[0])
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return InputError(cause.rule, file=file, key=cause.key, value=cause.value, fix=cause.fix)
    place = first["loc"]
    key = written(place)
    if first["type"] == "extra_forbidden":
        owner, _ = field_at(model, place[:-1])
        known = [info.alias or name for name, info in owner.model_fields.items()] if owner else []
        return InputError("is not a known key", file=file, key=key, fix=did_you_mean(str(place[-1]), known))
    _, field = field_at(model, place)
    fix = _fix(field)
    if first["type"] == "missing":
        return InputError("is missing", file=file, key=key, fix=fix)
    return InputError(_rule(first["msg"]), file=file, key=key, value=shown(_value(document, place)), fix=fix)


def written(place: Place) -> str:
    """Write a place in the document as one writes it: ``joints[0].links[2]``."""
    names = (part if isinstance(part, int) or re.fullmatch(r"[\w-]+", part) else f'"{part}"' for part in place)
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in names).removeprefix(".")


def _value(document: Any, place: Place) -> Any:
    """Return the value at a place of the document."""
    for part in place:
        document = document[part]
    return document


_NOUNS = {
    "dictionary": "a table",
    "tuple": "a list",
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
}


def _rule(message: str) -> str:
    """Pydantic's message in the words of a TOML file."""
    if "should have at least 1 " in message:
        return "must not be empty"
    if "exceeded maximum size" in message:
        return "must be a smaller number"
    if most := re.search(r"should have at most (\d+) items", message):
        return f"must have at most {most[1]} values"
    noun = next((ours for theirs, ours in _NOUNS.items() if f"valid {theirs}" in message), None)
    return f"must be {noun}" if noun else message.removeprefix("Value error, ").replace("Input should", "must")


def _fix(field: FieldInfo | None) -> str | None:
    """Say what to write instead, from the description and the unit of the field."""
    if field is None or field.description is None:
        return None
    unit = unit_of(field)
    return f"give the {field.description}" + (f" in {unit}" if unit else "")


def _is_table(annotation: Any) -> bool:
    """Whether an annotation is a dict, or a dict or None."""
    if get_origin(annotation) in (Union, types.UnionType):
        return any(_is_table(part) for part in get_args(annotation))
    return get_origin(annotation) is dict
