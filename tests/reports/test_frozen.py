"""Values of this room do not change once they are made."""

from frozen import changeable


def test_values_are_frozen() -> None:
    assert not changeable("reports")
