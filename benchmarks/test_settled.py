"""The rows of settled gaits, of one build against itself."""

import sys

import settled


def test_a_build_settles_the_same_gaits_as_itself_and_is_timed_in_each_turn():
    first, second = settled.compare([sys.executable] * 2, turns=2)
    assert first.keys() == second.keys() == settled.cases().keys()
    for name, (beats, *times) in first.items():
        assert beats == second[name][0] > 1
        assert len(times) == 2
        assert all(0 < seconds < 0.1 for seconds in times)
