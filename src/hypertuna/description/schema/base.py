"""Common parts of all tables of a file: frozen tables, ranges of numbers, conversion of units, checks.

An unknown key is refused (`Part`); `validation` writes the sentence. Keys of a file end in their unit (``length_m``);
attributes are in SI units and radians, and have no unit in their name.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainSerializer, model_validator

from hypertuna.errors import InputError, InputErrors, escaped, shown
from hypertuna.io.quantity import ZERO_CELSIUS
from hypertuna.ranges import FINITE, FRACTION, NOT_NEGATIVE, POSITIVE, Range

BEYOND = 1e12  # bound on all numbers [SI], larger than any value of a robot or of a trial


def number(limits: Range) -> Any:
    """Return the pydantic field of a number within limits; a missing limit is plus or minus `BEYOND`."""
    low = -BEYOND if limits.min is limits.above is None else limits.min
    high = BEYOND if limits.max is limits.below is None else limits.max
    return Field(strict=True, allow_inf_nan=False, ge=low, le=high, gt=limits.above, lt=limits.below)


def _scaled(factor: float) -> tuple[AfterValidator, PlainSerializer]:
    """Return the conversions of a number of the file: to SI by a factor, and back with 15 digits."""
    return AfterValidator(lambda x: x * factor), PlainSerializer(lambda x: float(f"{x / factor:.15g}"))


# Conversions of a number of the file to SI units, and back.
_TO_RADIANS, _TO_DEGREES = _scaled(math.pi / 180)
_TO_COULOMBS, _TO_AMPERE_HOURS = _scaled(3600.0)
_TO_SECONDS, _TO_MICROSECONDS = _scaled(1e-6)

# Types of values; those of angles, charges, pulses and temperatures are converted to SI units.
Real = Annotated[float, number(FINITE)]
Positive = Annotated[float, number(POSITIVE)]
NotNegative = Annotated[float, number(NOT_NEGATIVE)]
Negative = Annotated[float, number(Range(below=0))]
Fraction = Annotated[float, number(FRACTION)]
PositiveFraction = Annotated[float, number(Range(above=0, max=1))]
Degrees = Annotated[float, number(FINITE), _TO_RADIANS, _TO_DEGREES]
PositiveDegrees = Annotated[float, number(Range(above=0, max=180)), _TO_RADIANS, _TO_DEGREES]
QuarterTurn = Annotated[float, number(Range(min=-90, max=90)), _TO_RADIANS, _TO_DEGREES]  # an angle to either side
Amplitude = Annotated[float, number(Range(min=0, max=180)), _TO_RADIANS, _TO_DEGREES]
AmpereHours = Annotated[float, number(POSITIVE), _TO_COULOMBS, _TO_AMPERE_HOURS]
Microseconds = Annotated[float, number(POSITIVE), _TO_SECONDS, _TO_MICROSECONDS]
Celsius = Annotated[
    float,
    number(Range(above=-ZERO_CELSIUS)),
    AfterValidator(lambda celsius: celsius + ZERO_CELSIUS),
    PlainSerializer(lambda kelvin: float(f"{kelvin - ZERO_CELSIUS:.12g}")),
]
Count = Annotated[int, Field(strict=True, gt=0)]
Index = Annotated[int, Field(strict=True, ge=0)]
Flag = Annotated[bool, Field(strict=True)]


def _readable(text: str) -> str:
    """Return a text; ValueError if it is too long, or has control characters, which terminals would obey."""
    if escaped(text, "\n\t") != text or len(text) > MAX_TEXT:
        raise ValueError(f"must be at most {MAX_TEXT} characters, none of them a control character")
    return text


def _name(text: str) -> str:
    """Return a name; ValueError if it cannot be a part of file names, columns, NetCDF variables and figures."""
    if not NAME.fullmatch(text):
        raise ValueError("must be 1 to 60 letters, digits, spaces and - _ . + ( ) '")
    return text


def _names(table: dict[str, Any]) -> dict[str, Any]:
    """Return a table; ValueError if the name of an entry is invalid."""
    for name in table:
        _name(name)
    return table


MAX_TEXT = 20_000  # characters
NAME = re.compile(r"\w[\w .+()'-]{0,59}")  # valid names
Text = Annotated[str, Field(min_length=1), AfterValidator(_readable)]
Name = Annotated[str, Field(min_length=1), AfterValidator(_name)]
Named = AfterValidator(_names)  # validator of a table of named entries


class Scale(NamedTuple):
    """How a key scales from HyperTuna's value to that of another robot."""

    words: str  # the rule in words
    powers: Mapping[str, int]  # powers of the ratios of the robot to HyperTuna, by name of the ratio
    digits: int = 2  # significant digits of the result


class Radio(NamedTuple):
    """A parameter that the radio may set: its place, and the allowed range as factors on the described value.

    A limit may only become tighter, and a gain may be halved or doubled.
    """

    place: int  # place in the order of its part's parameters
    low: float = 0.5
    high: float = 2.0
    bounds: bool = False  # whether the range is in SI units instead
    whole: bool = False  # whether it is a whole number
    name: str = ""  # name of the parameter, if it differs from the key's


class Spread(NamedTuple):
    """Default range of an estimate, used if ``[uncertainty]`` of the file has no factor for it."""

    place: int  # place in the order of draws
    name: str  # in words
    low: float  # lowest factor on the estimate, or lowest amount added to it
    high: float
    added: bool = False  # whether the range is of amounts added
    along: tuple[str, ...] = ()  # keys of the same table that keep their ratio to this one

    def at(self, value: float, part: float) -> float:
        """Return the value at a part (0 to 1) of an estimate's range, on a logarithmic scale, or linear if added."""
        if self.added:
            return value + (self.low + (self.high - self.low) * part)
        return value * float(np.exp(math.log(self.low) + math.log(self.high / self.low) * part))


class Key(NamedTuple):
    """The declaration of a key of the file in its table."""

    description: str
    unit: str
    name: str | None  # name of the key, if it is not attribute and unit
    how: str  # how to find its value; empty: as for its table
    usual: tuple[float, float] | None  # range in the unit of the file, for robots in a lab, a lake or at sea
    radio: Radio | None
    scale: Scale | None
    follows: Mapping[str, int]  # powers with which it scales with length, mass or height of its link
    spread: Spread | None
    options: dict[str, Any]  # further options of the pydantic field

    def field(self, attribute: str) -> Any:
        """Return the pydantic field of a key; its name is attribute and unit unless another name is given."""
        ending = self.unit.lower().translate({ord("/"): "_", ord(" "): "_", ord("^"): None}).replace("degc", "c")
        key = self.name or f"{attribute}_{ending}".rstrip("_")
        extra: Any = {"unit": self.unit} if self.unit else None
        return Field(alias=key, description=self.description, json_schema_extra=extra, **self.options)


def entry(
    description: str,
    unit: str = "",
    *,
    key: str | None = None,
    how: str = "",
    usual: tuple[float, float] | None = None,
    radio: Radio | None = None,
    scale: Scale | None = None,
    follows: Mapping[str, int] | None = None,
    spread: Spread | None = None,
    **options: Any,
) -> Any:
    """Declare a key of the file, with its documentation; its name is attribute and unit unless `key` is given."""
    return Key(description, unit, key, how, usual, radio, scale, follows or {}, spread, options)


class Check(NamedTuple):
    """A rule on the values of a table: whether it holds, and the parts of its error."""

    holds: bool
    where: str  # attribute of the table, maybe with an index; or a key of the file, which has a dot
    text: str  # the rule
    fix: str
    value: str = ""  # default: the attribute's value in the unit of the file


class Part(BaseModel):
    """A table of the file: frozen, no unknown keys; its validator is built when the first file is read."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    table: ClassVar[str] = ""  # key of the table in errors
    renamed: ClassVar[Mapping[str, str]] = {}  # former keys of the table, refused with the present one
    declared: ClassVar[Mapping[str, Key]] = {}  # declarations of the keys, by attribute

    def __init_subclass__(
        cls, table: str = "", how: str = "", keys: Mapping[str, tuple[Any, Key]] | None = None, **options: Any
    ) -> None:
        """Turn the class's keys, and those of `keys` with their types, into fields of pydantic."""
        super().__init_subclass__(**options)
        cls.table = table
        for name, (kind, key) in (keys or {}).items():
            cls.__annotations__[name] = kind
            setattr(cls, name, key)
        declared = {name: value for name, value in vars(cls).items() if isinstance(value, Key)}
        cls.declared = {**cls.declared, **{name: key._replace(how=key.how or how) for name, key in declared.items()}}
        for name, key in declared.items():
            setattr(cls, name, key.field(name))

    @classmethod
    def scales(cls, *ratios: str) -> dict[str, Scale]:
        """Return the scales of the keys that depend on no ratios but the given ones."""
        scales = {cls.model_fields[name].alias or name: key.scale for name, key in cls.declared.items()}
        return {key: scale for key, scale in scales.items() if scale and scale.powers.keys() <= {*ratios}}

    @classmethod
    def scaled(cls, values: Mapping[str, float], **ratios: float) -> dict[str, float]:
        """Return values of another robot by key of the file, scaled from HyperTuna's; ratios: such as length=0.5."""
        return {
            key: float(f"{math.prod(ratios[name] ** power for name, power in powers.items()) * values[key]:.{digits}g}")
            for key, (_, powers, digits) in cls.scales(*ratios).items()
        }

    def _checks(self) -> Iterable[Check]:
        """Yield the checks of the table; the first check of a key that fails is the key's error."""
        return ()

    @model_validator(mode="after")
    def _make_checks(self) -> Self:
        errors: dict[str, InputError] = {}  # the first of each key
        try:
            for holds, where, text, fix, value in self._checks():
                if not holds:
                    key, present = self._entry(where)
                    errors.setdefault(key, InputError(text, key=key, value=value or present, fix=fix))
        except InputError as error:
            errors.setdefault(error.key or "", error)
        except (ArithmeticError, LookupError, ValueError):  # a check may need earlier ones to hold
            if not errors:
                raise
        if errors:
            raise InputErrors([*errors.values()])
        return self

    def _entry(self, where: str) -> tuple[str, str]:
        """Return key and value as in the file, given an attribute (maybe with an index) or a key."""
        if "." in where:
            return where, ""
        name, bracket, index = where.partition("[")
        key = f"{self.table}.{type(self).model_fields[name].alias}{bracket}{index}".removeprefix(".")
        value = self.model_dump(mode="json", include={name})[name]
        value = value[int(index[:-1])] if bracket else value
        return key, f"{value:g}" if isinstance(value, float) else shown(value)

    def ordered(self, low: str, high: str, *, equal: bool = False, fix: str = "exchange the two") -> Check:
        """Return the check that one value is less than another, or with `equal` at most equal."""
        below, above = getattr(self, low), getattr(self, high)
        holds = below < above or (equal and below == above)
        limit = "" if holds else f"{type(self).model_fields[high].alias} = {self._entry(high)[1]}"
        return Check(holds, low, f"must be {'at most' if equal else 'less than'} {limit}", fix)


def same_length(part: Part, key: str, count: int, per: str, but: tuple[str, ...] = ()) -> Iterator[Check]:
    """Yield the checks that each list in a table, except those in `but`, has `count` values, one per link or group."""
    for name, info in type(part).model_fields.items():
        column = getattr(part, name)
        if isinstance(column, tuple) and name not in but and name in part.model_fields_set:
            text, fix = f"must be {count} long, one value per {per}", f"give {count} value{'s' * (count != 1)}"
            yield Check(len(column) == count, f"{key}.{info.alias or name}", text, fix, f"{len(column)} long")


def inside(places: tuple[float, ...], lengths: tuple[float, ...], where: str, fix: str) -> Iterator[Check]:
    """Yield the checks that a place on each link is within the link's length [m]."""
    for i, (place, length) in enumerate(zip(places, lengths, strict=True)):
        text = f"must lie inside the link, at most its length_m = {length:g}"
        yield Check(place <= length, f"{where}[{i}]", text, fix, f"{place:g}")


def unique(names: tuple[str, ...], key: str) -> Iterator[Check]:
    """Yield the checks that all names differ; `key` has a placeholder for the index."""
    for i, name in enumerate(names):
        fix = "give each its own name"
        yield Check(name not in names[:i], key.format(i), "must be unique", fix, repr(name))
