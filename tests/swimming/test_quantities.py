"""A quantity of a settled beat is declared once, in the core: all that shows one has every one of the table."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hypertuna as ht
from host_library import InNode, Native
from hypertuna import _core, metrics
from hypertuna.io.quantity import label
from hypertuna.optimization.objective import OBJECTIVES, objective
from hypertuna.swimming.beat import DIFFERENTIABLE, QUANTITIES, settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.swim import SUMMARY

# Those of the search, which say how good the numbers are; an optimization has its own rule for them.
OF_THE_SEARCH = {"spectral_radius", "change_per_beat", "distance_to_settled", "beats"}


@pytest.fixture(scope="module")
def gait() -> ht.Gait:
    """A gait that turns."""
    return ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40), bias=(0, 5))


def test_every_result_has_every_quantity(tuna: ht.Robot, gait: ht.Gait) -> None:
    swim, sweep, gradient = ht.swim(tuna, gait), ht.sweep(tuna, [gait]), ht.gradient(tuna, gait)
    for name, about in QUANTITIES.items():
        assert getattr(swim, name) == sweep[name].item(), name
        assert (sweep[name].units, sweep[name].long_name) == (about.unit, about.meaning)
        if about.shown:
            of_summary = next(q for key, q in swim.summary().items() if key.startswith(name) and q.value == sweep[name])
            assert of_summary.unit == about.shown_unit
    assert gradient.derivatives.keys() == {*DIFFERENTIABLE} == {n for n, a in QUANTITIES.items() if a.differentiable}
    assert gradient.derivatives.keys() | {"efficiency", "turn_rate", "turn_radius"} == QUANTITIES.keys() - OF_THE_SEARCH
    with pytest.raises(AttributeError, match="Gradient has no sped"):
        gradient.sped  # noqa: B018


def test_every_quantity_that_can_be_better_is_an_objective() -> None:
    assert OBJECTIVES.keys() == QUANTITIES.keys() - OF_THE_SEARCH - {"turn_rate"}
    for name, large in OBJECTIVES.items():
        assert objective(name).terms == ((name, -1.0 if large else 1.0),)
    assert [name for name, large in OBJECTIVES.items() if large] == ["speed", "speed_bl", "stride_length", "efficiency"]


def test_labels_are_those_of_the_terminal() -> None:
    for name, about in QUANTITIES.items():
        words, _, note = about.label.partition(", ")
        assert label(name, note) == about.label
        assert words == label(name)
    assert [*SUMMARY][:3] == ["speed", "speed_bl", "mechanical_power"]


VERDICTS = {  # status, spectral radius, turn [rad]
    "settled": (0, 0.75, 0.0),
    "slow": (0, 0.9998, 0.1),
    "by hand": (0, math.nan, 0.0),
    "unsettled": (1, 0.5, 4.0),
    "unstable": (2, 1.012, 0.0),
    "wild": (2, 3.2, -4.0),
    "unresolved": (4, math.nan, math.nan),
    "diverged": (3, math.nan, math.nan),
}


@pytest.mark.parametrize("where", [Native, InNode], ids=["native", "wasm"])
def test_a_verdict_reads_the_same_everywhere(where: type[Native | InNode]) -> None:
    host = where()
    count = next(k for k in range(100) if not host.call("ht_quantity", k))
    names = [host.read(host.call("ht_quantity", k)).decode() for k in range(count)]
    for status, radius, turn in VERDICTS.values():
        values = {"status": status, "beats": 41, "distance_to_settled": 2.5e-9, "spectral_radius": radius}
        values["turn_rate"] = turn * 2
        text, numbers = np.zeros(400, np.uint8), np.array([values.get(name, 0.0) for name in names])
        host.call("ht_verdict", np.array([2.0]), numbers, text, len(text))
        sentence = text.tobytes().split(b"\0")[0].decode()
        assert sentence == _core.verdict(status, 41, 2.5e-9, radius, turn)
        assert ("It spins" in sentence) == (abs(turn) > math.pi)
    assert sentence == (
        "The gait diverged within 41 beats: its speeds grew beyond all bounds; check the robot first "
        "(`hypertuna robot check FILE`), then use more steps per beat."
    )
    host.close()


@pytest.mark.parametrize("where", [Native, InNode], ids=["native", "wasm"])
def test_the_interface_has_every_quantity_with_label_and_unit(where: type[Native | InNode]) -> None:
    host = where()

    def texts(call: str, count: int) -> list[str]:
        return [host.read(host.call(call, k)).decode() for k in range(count)]

    count = next(k for k in range(100) if not host.call("ht_quantity", k))
    names = texts("ht_quantity", count)
    assert {*names} - {*QUANTITIES} == {"status", "arrived", "approach_beats"}
    assert [name for name in names if name in QUANTITIES] == [*QUANTITIES]
    rows = zip(names, texts("ht_quantity_label", count), texts("ht_quantity_unit", count), strict=True)
    for k, (name, words, unit) in enumerate(rows):
        if name in QUANTITIES:
            about = QUANTITIES[name]
            assert (words, unit) == (about.label, about.shown_unit)
            assert host.call("ht_quantity_shown", k) == about.shown
    slopes = next(k for k in range(100) if not host.call("ht_derivative", k))
    assert texts("ht_derivative", slopes) == [*DIFFERENTIABLE]
    host.close()


def test_formulas_are_those_of_the_metrics(tuna: ht.Robot, gait: ht.Gait) -> None:
    """To the bit, at rest too: the bias alone moves nothing."""
    still = ht.Gait.from_degrees(frequency=2, amplitude=(0, 0), phase=(0, 0))
    swum = settle(tuna, Gaits.of([gait, still]))
    body, frequency, speed = tuna.body, np.array([2.0, 2.0]), swum["speed"]
    expected = {
        "speed_bl": speed / body.length,
        "cost_of_transport": metrics.cost_of_transport(swum["mechanical_power"], body.mass, speed),
        "cost_of_transport_positive": metrics.cost_of_transport(swum["mechanical_power_positive"], body.mass, speed),
        "strouhal": metrics.strouhal(frequency, swum["tail_excursion"], speed),
        "stride_length": metrics.stride_length(speed, frequency, body.length),
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(swum[name], values, name)
    assert 0 < swum["efficiency"][0] < 1
    assert math.isnan(swum["efficiency"][1])  # no power is spent
