"""A number of a result as users read it."""

import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple, get_type_hints

DEGREES = 180 / math.pi  # in a radian


class Quantity(NamedTuple):
    """One line of a result's summary: what the terminal's table and the JSON object say."""

    value: Any  # in `unit`
    unit: str  # empty without one
    label: str | None  # on the terminal; empty: the quantity above in another unit; None: not on the terminal


class Column(NamedTuple):
    """Name and unit of a result's field in JSON and files: ``corner: Annotated[float, Column("corner_hz")]``."""

    name: str
    factor: float = 1.0  # from SI
    divisor: float = 1.0  # from SI
    offset: float = 0.0  # from SI


def columns(result: Any) -> dict[str, Any]:
    """Return the fields of a result that have a `Column`, by its name and in its unit."""
    values = {}
    for key, (name, factor, divisor, offset) in _columns(type(result)).items():  # type: ignore[arg-type]  # mypy: a type has no hash
        value = getattr(result, key)
        values[name] = value * factor / divisor + offset if isinstance(value, float) else value
    return values


@functools.cache
def _columns(kind: type) -> dict[str, Column]:
    """Return the columns of a type of results, by the names of their fields."""
    hints = get_type_hints(kind, include_extras=True).items()
    return {key: part for key, hint in hints for part in getattr(hint, "__metadata__", ()) if isinstance(part, Column)}


def values_of(summary: Mapping[str, Quantity]) -> dict[str, Any]:
    """Return the values of a summary, as the JSON object has them."""
    return {key: quantity.value for key, quantity in summary.items()}
