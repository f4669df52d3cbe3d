"""Ranges: what they accept, and the sentence of what they refuse."""

import math
from typing import Any

import pytest

from hypertuna.description.robot import load, require
from hypertuna.errors import InputError
from hypertuna.ranges import (
    CELL,
    FINITE,
    FRACTION,
    NOT_NEGATIVE,
    POSITIVE,
    POSITIVE_WHOLE,
    WHOLE,
    Range,
    Whole,
    check_choice,
    check_name,
)

REFUSED = [
    (FINITE, math.nan, "must be a finite number, but is nan"),
    (FINITE, "1", "must be a finite number, but is '1'"),
    (FINITE, True, "must be a finite number, but is true"),
    (POSITIVE, 0, "must be greater than 0, but is 0"),
    (NOT_NEGATIVE, -0.5, "must not be negative, but is -0.5"),
    (FRACTION, 1.5, "must be from 0 to 1, but is 1.5"),
    (Range(min=0, below=0.5), 0.5, "must be at least 0 and less than 0.5, but is 0.5"),
    (WHOLE, 5.0, "must be a whole number, but is 5.0"),
    (WHOLE, True, "must be a whole number, but is true"),
    (POSITIVE_WHOLE, 0, "must be at least 1, but is 0"),
    (Whole(min=1, max=1024), 2000, "must be from 1 to 1024, but is 2000"),
]


@pytest.mark.parametrize(("limits", "value", "sentence"), REFUSED)
def test_values_out_of_range_are_refused(limits: Any, value: object, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        limits.check(value, "key", "fix")
    assert str(caught.value) == f"key {sentence}: fix."


def test_values_in_range_are_returned_as_numbers() -> None:
    assert POSITIVE.check(2, "key") == 2.0
    assert isinstance(POSITIVE.check(2, "key"), float)
    assert Whole(min=1, max=3).check(3, "key") == 3


@pytest.mark.parametrize(
    ("limits", "inside", "outside"),
    [
        (Range(min=1.0), 1.0, math.nextafter(1, 0)),
        (Range(max=1.0), 1.0, math.nextafter(1, 2)),
        (Range(above=1.0), math.nextafter(1, 2), 1.0),
        (Range(below=1.0), math.nextafter(1, 0), 1.0),
        (Whole(min=1), 1, 0),
        (Whole(max=1), 1, 2),
        (POSITIVE, 5e-324, 0.0),
        (NOT_NEGATIVE, 0.0, -5e-324),
        (POSITIVE_WHOLE, 1, 0),
        (FINITE, 1.7976931348623157e308, math.inf),
    ],
)
def test_a_limit_is_exact(limits: Any, inside: float, outside: float) -> None:
    assert inside in limits
    assert outside not in limits


def test_ranges_are_frozen_and_made_by_names() -> None:
    for kind in (Range, Whole):
        with pytest.raises(AttributeError):
            kind(min=1).min = 2  # type: ignore[misc]
        with pytest.raises(TypeError):
            kind(1)  # type: ignore[misc]


def test_cells_of_tables_are_numbers_up_to_a_million_million() -> None:
    assert [CELL.check(value, "key") for value in (-1e12, 0.0, 1e12)] == [-1e12, 0.0, 1e12]
    for value in (-1.01e12, 1.01e12):
        with pytest.raises(InputError, match="key must be from"):
            CELL.check(value, "key", "fix")


@pytest.mark.parametrize(
    ("words", "choice"), [(["air"], "air"), (["air", "oil"], "air or oil"), (["air", "oil", "gas"], "air, oil or gas")]
)
def test_a_word_that_is_none_of_few_gets_all_of_them(words: list[str], choice: str) -> None:
    assert check_choice(words[-1], words, "key") == words[-1]
    with pytest.raises(InputError, match=f"^key must be {choice}, but is"):
        check_choice("water", words, "key")


def test_unknown_names_get_the_nearest() -> None:
    assert check_name("ned", ("ned", "enu"), "frame", "frame") == "ned"
    with pytest.raises(InputError, match=r"^frame must be a known frame, but is 'nad': did you mean ned\?$"):
        check_name("nad", ("ned", "enu"), "frame", "frame")


@pytest.mark.parametrize(
    ("key", "fix"),
    [
        ("pump", r"add the table \[pump\]"),
        ("joints.I.line", r"add the table \[joints\.line\]"),
        ("servos[1].voltage_v", r"give the voltage of torque and speed \[V\]"),
    ],
)
def test_a_missing_value_is_named_with_its_fix_from_the_schema(key: str, fix: str) -> None:
    assert require(1.0, key) == 1.0
    with pytest.raises(InputError, match=rf"^robots/rexeel\.toml: .* is missing: {fix}\.$"):
        require(None, key, load("rexeel"))
