"""Values of this room do not change once they are made."""

import pytest

from frozen import changeable

pytest.importorskip("gymnasium", reason="needs the extra rl")


def test_values_are_frozen() -> None:
    assert changeable("learning") == ["Swimmers"]  # whose state goes on with each step
