"""What every table of a file is made of: frozen parts, kinds of numbers, conversion of units, common checks.

Keys of a file carry the unit (``length_m``); attributes are SI and radians and carry none.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainSerializer

from hypertuna.errors import InputError


def _scaled(factor: float) -> tuple[AfterValidator, PlainSerializer]:
    """Convert a number of the file to SI by a factor, and back to 15 digits."""
    return AfterValidator(lambda x: x * factor), PlainSerializer(lambda x: float(f"{x / factor:.15g}"))


_RULES: dict[str, Any] = {"strict": True, "allow_inf_nan": False}
_TO_RADIANS, _TO_DEGREES = _scaled(math.pi / 180)
_TO_COULOMBS, _TO_AMPERE_HOURS = _scaled(3600.0)
_TO_SECONDS, _TO_MICROSECONDS = _scaled(1e-6)
_ZERO_CELSIUS = 273.15

Real = Annotated[float, Field(**_RULES)]
Positive = Annotated[float, Field(**_RULES, gt=0)]
NotNegative = Annotated[float, Field(**_RULES, ge=0)]
Negative = Annotated[float, Field(**_RULES, lt=0)]
Fraction = Annotated[float, Field(**_RULES, ge=0, le=1)]
PositiveFraction = Annotated[float, Field(**_RULES, gt=0, le=1)]
Degrees = Annotated[float, Field(**_RULES), _TO_RADIANS, _TO_DEGREES]
PositiveDegrees = Annotated[float, Field(**_RULES, gt=0, le=180), _TO_RADIANS, _TO_DEGREES]
NotNegativeDegrees = Annotated[float, Field(**_RULES, ge=0), _TO_RADIANS, _TO_DEGREES]
Amplitude = Annotated[float, Field(**_RULES, ge=0, le=180), _TO_RADIANS, _TO_DEGREES]
AmpereHours = Annotated[float, Field(**_RULES, gt=0), _TO_COULOMBS, _TO_AMPERE_HOURS]
Microseconds = Annotated[float, Field(**_RULES, gt=0), _TO_SECONDS, _TO_MICROSECONDS]
Celsius = Annotated[
    float,
    Field(**_RULES, gt=-_ZERO_CELSIUS),
    AfterValidator(lambda celsius: celsius + _ZERO_CELSIUS),
    PlainSerializer(lambda kelvin: float(f"{kelvin - _ZERO_CELSIUS:.12g}")),
]
Count = Annotated[int, Field(strict=True, gt=0)]
Index = Annotated[int, Field(strict=True, ge=0)]
Flag = Annotated[bool, Field(strict=True)]
Text = Annotated[str, Field(min_length=1)]


def entry(alias: str, description: str, unit: str = "", **options: Any) -> Any:
    """Declare a key of the file: its name there, what it means, its unit."""
    return Field(alias=alias, description=description, json_schema_extra={"unit": unit} if unit else None, **options)


class Part(BaseModel):
    """A table of the file: frozen, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def same_length(part: Part, key: str, count: int, per: str, but: tuple[str, ...] = ()) -> None:
    """Check that every list of a table, but those named, has one value per link or joint group."""
    for name, info in type(part).model_fields.items():
        column = getattr(part, name)
        if isinstance(column, tuple) and len(column) != count and name not in but:
            raise InputError(
                f"must be {count} long, one value per {per}",
                key=f"{key}.{info.alias or name}",
                value=f"{len(column)} long",
                fix=f"give {count} value{'s' * (count != 1)}",
            )


def unique(names: tuple[str, ...], key: str) -> None:
    """Check that no two things have the same name."""
    for i, name in enumerate(names):
        if name in names[:i]:
            raise InputError("must be unique", key=key.format(i), value=repr(name), fix="give each its own name")
