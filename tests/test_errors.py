"""An error is one sentence with file, key, rule, value and fix; long names are cut, control characters written out."""

import pickle
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import numpy as np
import pytest

from hypertuna import InputError
from hypertuna.errors import LISTED, InputErrors, did_you_mean, escaped, shown, with_article

BELOW = InputError("must be above 0", file="a.toml", key="mass_kg", value="-1", fix="weigh it")
EMPTY = InputError("must not be empty", file="a.toml", key="name")


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ({}, "must be so."),
        ({"file": "a.toml"}, "a.toml must be so."),
        ({"file": "a.toml", "key": "k"}, "a.toml: k must be so."),
        ({"key": "k", "value": "1"}, "k must be so, but is 1."),
        ({"key": "k", "value": "1", "fix": "write 2"}, "k must be so, but is 1: write 2."),
        ({"key": "k", "fix": "did you mean l?"}, "k must be so: did you mean l?"),
        ({"key": "k\x1b"}, "k\\u001b must be so."),
        ({"key": "k" * 300}, f"{'k' * 300} must be so."),
        ({"key": "k" * 301}, f"{'k' * 150}...{'k' * 150} must be so."),
    ],
)
def test_a_sentence_has_what_is_known(parts: dict[str, Any], sentence: str) -> None:
    assert str(InputError("must be so", **parts)) == sentence


@pytest.mark.parametrize(
    ("errors", "paste", "whole", "text"),
    [
        ([BELOW], (), (), "a.toml: mass_kg must be above 0, but is -1: weigh it."),
        (
            [BELOW, EMPTY],
            (),
            (),
            "a.toml has 2 mistakes:\n  1. mass_kg must be above 0, but is -1: weigh it.\n  2. name must not be empty.",
        ),
        (
            [EMPTY],
            ("name = 'a'",),
            (),
            "a.toml: name must not be empty.\nTo paste, with example values to replace:\n\nname = 'a'",
        ),
        (
            [EMPTY],
            ("name = 'a'",),
            (True,),
            "a.toml: name must not be empty.\nTo paste in place of the whole file, as `hypertuna robot new` writes it,"
            " with example values to replace:\n\nname = 'a'",
        ),
    ],
)
def test_mistakes_of_a_file_are_listed(
    errors: Sequence[InputError], paste: tuple[str], whole: tuple[bool], text: str
) -> None:
    error = InputErrors(errors, *paste, *whole)
    assert str(error) == str(pickle.loads(pickle.dumps(error))) == text
    first = errors[0]
    assert (error.file, error.key, error.value, error.fix) == (first.file, first.key, first.value, first.fix)


@pytest.mark.parametrize("more", [0, 1, 7])
def test_fifteen_mistakes_are_listed(more: int) -> None:
    head, *lines = str(InputErrors([EMPTY] * (LISTED + more))).splitlines()
    assert head == f"a.toml has {15 + more} mistakes:"
    assert [line.split(".")[0].strip() for line in lines[:15]] == [f"{k + 1}" for k in range(15)]
    assert lines[15:] == [f"  and {more} more, which often follow from these"] * (more > 0)


def test_an_unknown_name_gets_the_nearest_or_all() -> None:
    assert did_you_mean("spede", ["mass", "speed"]) == "did you mean speed?"
    assert did_you_mean("speed1", ["speed2", "speed3"]) == "did you mean speed3?"
    assert did_you_mean("x", []) == "remove it"
    assert did_you_mean("x", ["mass", "speed"]) == "use one of mass, speed"
    names = [f"name{k}" for k in range(14)]
    for count, more in ((12, ""), (13, " and 1 more"), (14, " and 2 more")):
        assert did_you_mean("x", names[:count]) == f"use one of {', '.join(names[:12])}{more}"


@pytest.mark.parametrize(
    ("text", "keep", "safe"),
    [
        ("plain Ä", "", "plain Ä"),
        ("a\tb\nc", "", "a\\u0009b\\u000ac"),
        ("a\tb\nc", "\n", "a\\u0009b\nc"),
        ("a\tb\nc", "\t", "a\tb\\u000ac"),
        ("a\N{NO-BREAK SPACE}b\x07", "", "a\N{NO-BREAK SPACE}b\\u0007"),  # a space moves nothing, but prints nothing
        ("\N{RIGHT-TO-LEFT OVERRIDE}\U000e0001", "", "\\u202e\\udb40\\udc01"),  # two code units of four digits
    ],
)
def test_control_characters_are_written_as_in_json(text: str, keep: str, safe: str) -> None:
    assert escaped(text, keep) == safe


class Odd:
    """Of no type that is written out."""


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (False, "false"),
        (1, "1"),
        (0, "0"),
        (None, "None"),
        ("a", "'a'"),
        ([1, "b"], "[1, 'b']"),
        ((), "()"),
        (PurePath("a"), "PurePosixPath('a')"),
        (np.array([[1, 2], [3, 4]]), "array([[1, 2], [3, 4]])"),
        (np.float64(2.5), repr(np.float64(2.5))),
        ([np.ones(1)], "[array([1.])]"),
        (Odd(), "an Odd"),
        ([Odd(), Odd(), 1], "a list of Odd, int"),
        ((Odd(),), "a tuple of Odd"),
        ("a" * 58, f"'{'a' * 58}'"),
        ("a" * 59, f"'{'a' * 56}..."),
    ],
)
def test_a_value_is_shown_in_sixty_characters(value: object, text: str) -> None:
    assert " ".join(shown(value).split()) == text


def test_a_number_that_python_does_not_write_is_named() -> None:
    assert shown(10**5000) == "a number of more than 4300 digits"


def test_names_of_types_have_their_article() -> None:
    for kind, text in (("Swim", "a Swim"), ("Optimum", "an Optimum"), ("Gaits", "Gaits"), ("Executor", "an Executor")):
        assert with_article(kind) == text
