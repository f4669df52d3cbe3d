"""Damaged films end in a result or in a sentence, in time and memory; more of them: validation/film/damaged.py."""

from damaged import judged


def test_damaged_films_end_in_a_sentence() -> None:
    outcomes, wrong = judged(100)
    assert not wrong
    assert outcomes["read"] > 20
    assert outcomes["refused"] > 20
