"""Quantities: numbers of results with unit and label, as users read them."""

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, get_type_hints

DEGREES = 180 / math.pi  # per radian
ZERO_CELSIUS = 273.15  # K


class Quantity(NamedTuple):
    """One line of a result's summary: what the terminal's table and the JSON object say."""

    value: Any  # in `unit`
    unit: str  # empty without one
    label: str | None  # on the terminal; empty: the quantity above in another unit; None: not on the terminal


class Format(NamedTuple):
    """How a result's attribute is written: ``corner: Annotated[float, Format("Hz")]`` is ``corner_hz`` in JSON."""

    unit: str = ""
    note: str | None = ""  # behind its name on the terminal; None: not on the terminal


# Unit -> factor, divisor and offset of the value in it: SI value * factor / divisor + offset.
SCALES = {
    "deg": (DEGREES, 1.0, 0.0),
    "degC": (1.0, 1.0, -ZERO_CELSIUS),
    "kPa": (1.0, 1e3, 0.0),
    "kPa deg": (DEGREES, 1e3, 0.0),
    "mm": (1e3, 1.0, 0.0),
    "mm^2/s": (1e6, 1.0, 0.0),
    "km": (1.0, 1e3, 0.0),
    "h": (1.0, 3600.0, 0.0),
    "Wh": (1.0, 3600.0, 0.0),
}
# Names whose label is not made of the same words.
NUMBERS = {"strouhal": "Strouhal number", "reynolds": "Reynolds number"}
ENDS = ("max", "min", "peak")  # last words of names; in labels they come first


def suffix(unit: str) -> str:
    """Return the end of a name in JSON and files for a unit: _m_s for m/s, nothing for 1 and for body lengths."""
    if unit in ("", "1", "BL per beat"):
        return ""
    name = unit.replace("degC", "C").lower()
    name = name.replace("/(", "_per_").replace(")", "").replace("/", "_").replace(" ", "_").replace("^", "")
    return "_" + name.removeprefix("1_")


def label(name: str, note: str = "") -> str:
    """Return what the terminal calls a quantity: the words of its name in Python, and maybe a note."""
    words = name.split("_")
    leading = [words.pop()] if words[-1] in ENDS else []
    text = " ".join([*leading, *words]).removesuffix(" bl")
    return f"{NUMBERS.get(text, text)}{', ' * bool(note)}{note}"


def summarized(result: Any, shown: Mapping[str, Format]) -> dict[str, Quantity]:
    """Return the attributes of a result as quantities, by their names in JSON."""
    return {
        key_of(name, unit): quantity(name, getattr(result, name), unit, note) for name, (unit, note) in shown.items()
    }


def quantity(name: str, value: Any, unit: str = "", note: str | None = "") -> Quantity:
    """Return a value [SI] as users read it."""
    text = None if note is None else "" if name.endswith("_bl") else label(name, note)
    return Quantity(scaled(value, unit), unit, text)


def key_of(name: str, unit: str = "") -> str:
    """Return the name of a quantity in JSON and files: that in Python, and its unit."""
    return name + (suffix(unit) if not name.endswith("_bl") else suffix(unit).removeprefix("_bl"))


def scaled(value: Any, unit: str) -> Any:
    """Return a value [SI] in a unit."""
    if unit not in SCALES or value is None:
        return value
    factor, divisor, offset = SCALES[unit]
    return value * factor / divisor + offset


def columns(result: Any) -> dict[str, Any]:
    """Return the fields of a result that have a `Format`: name in files -> value in the unit of the format."""
    values = {}
    for name, (unit, _) in _columns(type(result)).items():  # type: ignore[arg-type]  # mypy: a type has no hash
        values[key_of(name, unit)] = scaled(getattr(result, name), unit)
    return values


def column_units(kind: type) -> dict[str, str]:
    """Return the units of the `columns` of a type of results."""
    return {key_of(name, unit): unit for name, (unit, _) in _columns(kind).items()}


@functools.cache
def _columns(kind: type) -> dict[str, Format]:
    """Return the formats of the fields that are columns, of a type of results, by field."""
    hints = get_type_hints(kind, include_extras=True).items()
    return {key: part for key, hint in hints for part in getattr(hint, "__metadata__", ()) if isinstance(part, Format)}


def values_of(summary: Mapping[str, Quantity]) -> dict[str, Any]:
    """Return the values of a summary, as the JSON object has them."""
    return {key: quantity.value for key, quantity in summary.items()}


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural except for 1."""
    return f"{number} {noun}{'s' * (number != 1)}"


def listed(parts: Sequence[str]) -> str:
    """Return parts of a sentence joined: a, b and c."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
