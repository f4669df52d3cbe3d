"""What the stored draws of the story must show."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

HERE = Path(__file__).parent
HIDDEN = {"drag_tangential": (2.0, 2.0), "drag_normal": (0.667, 1.5), "added_mass_normal": (1.25, 2.0)}  # factor, prior


@pytest.mark.parametrize("name", ["story", "tracks"])
def test_intervals_hold_the_truth_and_are_narrower_than_priors(name: str) -> None:
    text = (HERE / f"{name}.json").read_text()
    assert '"/' not in text  # no place of the machine that filmed
    lines = json.loads(text)
    assert len(lines) >= 20  # a later run adds some
    each = [(*line["factors"][key][1:], *known) for line in lines.values() for key, known in HIDDEN.items()]
    assert sum(low <= true <= high for low, high, true, _ in each) >= 0.9 * len(each)
    assert all(math.log(high / low) < 2 * 1.96 * math.log(prior) for low, high, _, prior in each)
    worst = [max(abs(one["fit"]) for one in line["speed_error_percent"].values()) for line in lines.values()]
    assert sum(error <= 3 for error in worst) >= 0.9 * len(lines)
