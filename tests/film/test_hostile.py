"""Films that a tracker may get wrong, drawn and tracked as in validation/film/hostile.py: a few that take seconds."""

import json

import pytest
from hostile import FILMS, RESULT, outcome


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("two takes in one film", "jumps after 0.48 s"),
        ("portrait, HEVC", "few: six show"),
        ("trimmed on the phone", "no steady beat"),
        ("slow motion, no rate", "is the film slow motion"),
        ("doubled frames", "50 % that repeat others"),
        ("second fish, touching", "touches no other fish"),
    ],
)
def test_what_comes_of_a_film_is_what_the_table_says(name, found) -> None:
    stored = {one["name"]: one for one in json.loads(RESULT.read_text())}[name]
    now = outcome(name)
    assert now["outcome"] == stored["outcome"]
    assert found in str(now)


def test_the_table_has_every_film() -> None:
    assert [one["name"] for one in json.loads(RESULT.read_text())] == list(FILMS)
