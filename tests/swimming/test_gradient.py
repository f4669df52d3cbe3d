"""Exact derivatives against differences of whole swims: every parameter of every model."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.swimming.beat import STATUSES, directional_derivatives, settle
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model, parameter_names
from models import MODELS, changed, fastest, turning

Array = NDArray[np.float64]

# A step of 1e-4 of the parameter makes the difference wrong by its square, 1e-8, times the third derivative (some tens
# at most), and by 1e-12 / 1e-4 of rounding. Kinks of v |v| and what the search leaves (1e-8 of a body length a beat,
# nearly the same on both sides) cost more: 3e-6 was seen, in units of the result per relative change of the parameter.
STEP = 1e-4
DIFFERENCES = 1e-5
# Positive power has a kink wherever a group's power changes sign. One of the 128 samples of the beat may do so within
# the step: the difference then has half of that sample's weight and not all or nothing of it.
KINKED = 1 / 128


RESULTS = ("speed", "cost_of_transport", "mechanical_power", "strouhal", "torque_peak", "mechanical_power_positive")


def explicit(robot: ht.Robot) -> ht.Robot:
    """The robot with every column written out, so that no value follows from another, and room for heavier links."""
    document = robot.document()
    parts = {"links": robot.links, "lumped": robot.water.lumped, "strip": robot.water.strip}
    for name, part in parts.items():
        if part is not None:
            owner = document if name == "links" else document["water"]
            owner[name] = part.model_dump(mode="json", by_alias=True)
    document["body"]["mass_kg"] *= 2
    document["sources"].clear()  # checked anew with each of hundreds of values
    return parse(document)


def place(robot: ht.Robot, name: str) -> tuple[list[str | int], float]:
    """Keys to a parameter in the robot's document, and its value: ``links.mass[3]`` is at links, mass_kg, 3."""
    column, _, index = name.partition("[")
    part: Any = robot
    keys: list[str | int] = []
    for attribute in column.split("."):
        if isinstance(part, tuple):  # joint groups: the index belongs to the list of them
            keys.append(int(index.rstrip("]")))
            part, index = part[int(index.rstrip("]"))], ""
        keys.append(type(part).model_fields[attribute].alias)
        part = getattr(part, attribute)
    if index:
        keys.append(int(index.rstrip("]")))
        part = part[int(index.rstrip("]"))]
    return keys, float(part)


def with_value(robot: ht.Robot, keys: list[str | int], value: float) -> ht.Robot:
    """The robot with one number of its description replaced; the body stays as long as its links."""
    document = robot.document()
    owner: Any = document
    for key in keys[:-1]:
        owner = owner[key]
    owner[keys[-1]] = math.degrees(value) if str(keys[-1]).endswith("_deg") else value
    document["body"]["length_m"] = sum(document["links"]["length_m"])
    return parse(document)


def result(robot: ht.Robot, gait: ht.Gait) -> Array:
    """What has derivatives."""
    beat = settle(robot, Gaits.of([gait]))  # `ht.swim` would follow a start from rest as well
    return np.array([beat[name][0] for name in RESULTS])


def slope(of: Callable[[float], Array], x: float, unit: float, *, full: bool = False) -> Array:
    """d of / dx times `unit`, by central differences; one-sided ones (of second order too) at 0 and at a full part."""
    h = STEP * unit
    if full:
        return (3 * of(x) - 4 * of(x - h) + of(x - 2 * h)) / (2 * STEP)
    if x > 0:
        return (of(x + h) - of(x - h)) / (2 * STEP)
    return (4 * of(x + h) - 3 * of(x) - of(x + 2 * h)) / (2 * STEP)


def differences(robot: ht.Robot, gait: ht.Gait) -> tuple[Array, Array]:
    """Derivatives by every parameter (parameters, results) by differences, and the unit of each: its own size."""
    rows, units = [], []
    for name in parameter_names(robot):
        if name.startswith("gait."):
            attribute, _, index = name.removeprefix("gait.").partition("[")
            k = int(index.rstrip("]")) if index else None
            known = getattr(gait, attribute)

            def of(x: float, attribute: str = attribute, k: int | None = k, known: Any = known) -> Array:
                return result(robot, replace(gait, **{attribute: x if k is None else (*known[:k], x, *known[k + 1 :])}))

            x, unit = (known, known) if k is None else (known[k], 1.0)
            # a phase or a bias may well be negative: never at the edge of what is allowed
            rows.append((of(x + STEP * unit) - of(x - STEP * unit)) / (2 * STEP))
        elif name.startswith("joints.bandwidth") and robot.model.joints == "ideal":
            unit = 1.0
            rows.append(np.zeros(len(RESULTS)))
        else:
            keys, x = place(robot, name)
            unit = x or (1e-3 if "blunt_area" in name else 1.0)  # m^2, of the size of a head's
            full = x == 1 and name.endswith(("tail_shedding", "edge_lift", "edge_suction"))
            if name.endswith(("edge_height", "edge_aspect", "edge_added_mass")) and x == 0:  # no fin of its own
                rows.append(np.zeros(len(RESULTS)))
                units.append(unit)
                continue
            rows.append(
                slope(lambda value, keys=keys: result(with_value(robot, keys, value), gait), x, unit, full=full)
            )
        units.append(unit)
    return np.array(rows), np.array(units)


# A turn has what a straight swim has, but a torque that is the same to both sides: that, once for each law. The
# derivatives of cross flow are those of the eel, of fewer parameters.
CASES = [(name, turning) for name in MODELS if name != "hypertuna-strip-cross-flow"]
CASES += [(name, fastest) for name in MODELS if name.endswith(("lumped", "strip", "elongated"))]


@pytest.mark.parametrize(("name", "gait_of"), CASES)
def test_every_derivative_of_every_model(name: str, gait_of: Callable[[ht.Robot], ht.Gait]) -> None:
    area = MODELS[name].links.lateral_area
    robot = with_value(MODELS[name], ["links", "lateral_area_m2"], [*area[:-1], 1.02 * area[-1]])  # no step, no kink
    robot = explicit(robot)
    gait = gait_of(robot)
    found = ht.gradient(robot, gait)
    assert found.names == parameter_names(robot)
    expected, units = differences(robot, gait)
    size = abs(result(robot, gait))
    exact = np.stack([getattr(found, name) for name in RESULTS], axis=1)
    error = abs(exact * units[:, None] - expected) / size
    if gait_of is fastest:  # straight: the same largest torque to both sides, and a bias makes one of them larger
        by_bias = [parameter.startswith("gait.bias") for parameter in found.names]
        error[by_bias, RESULTS.index("torque_peak")] = 0
    for k, (key, allowed) in enumerate(zip(RESULTS, (*(len(RESULTS) - 1) * [DIFFERENCES], KINKED), strict=True)):
        worst = error[:, k].argmax()
        assert error[worst, k] < allowed, f"{key} by {found.names[worst]}"


def test_the_largest_rate_by_hand(tuna: ht.Robot) -> None:
    """2 pi f A / sqrt(1 + x^2) with x = f / f_b: joint II swings farther, and joint I does not matter."""
    gait = fastest(tuna)
    found, rate = ht.gradient(tuna, gait), ht.swim(tuna, gait).rate_peak
    f, bandwidth, amplitude = gait.frequency, 4.7, gait.amplitude[1]
    left = 1 + (f / bandwidth) ** 2
    assert rate == pytest.approx(2 * math.pi * f * amplitude / math.sqrt(left), rel=1e-12)
    by_hand = {
        "gait.frequency": rate / f / left,
        "gait.amplitude[1]": rate / amplitude,
        "joints.bandwidth[1]": rate / bandwidth * (1 - 1 / left),
    }
    for name, slope_by_parameter in zip(found.names, found.rate_peak, strict=True):
        assert slope_by_parameter == pytest.approx(by_hand.get(name, 0.0), rel=1e-12), name


def test_every_parameter_matters(every_model: ht.Robot) -> None:
    """Zeros would agree with differences that change nothing: hardly any parameter may have no effect."""
    found = ht.gradient(every_model, fastest(every_model))
    idle = {name for name, value in zip(found.names, found.mechanical_power, strict=True) if value == 0}
    expected = (
        {name for name in found.names if name.startswith("joints.bandwidth")}
        if every_model.model.joints == "ideal"
        else set()
    )
    if every_model.model.water == "lumped":
        expected.add(f"links.length[{len(every_model.links.name) - 1}]")  # forces act at centers of mass
    if every_model.model.water == "strip":
        expected |= idle_strips(every_model)
    assert idle == expected


def idle_strips(robot: ht.Robot) -> set[str]:
    """Coefficients of the strips without effect: beating where nothing bends, the edge where nothing is shed."""
    strip = robot.water.strip
    assert strip is not None
    first = min(link for group in robot.joints for link in group.links)
    names = {f"water.strip.drag_beating[{link}]" for link in range(first)}
    edge = {f"water.strip.edge_{what}" for what in ("height", "aspect", "added_mass", "lift", "suction")}
    plate = {"water.strip.edge_aspect", "water.strip.edge_added_mass"}
    height = np.array(robot.links.lateral_area) / np.array(robot.links.length)
    if strip.edge_height == 0:
        names |= plate | {"water.strip.edge_height"}
    elif strip.edge_aspect == 0:
        names |= plate
    else:
        names.add("water.strip.edge_added_mass")  # all that HyperTuna's last link has is its fin's
    if strip.edge_height == 0 and height[-2] >= height[-1]:  # no leading edge
        names.add("water.strip.edge_suction")
    if strip.tail_shedding == 0:
        names |= edge
    return names


def test_one_time_for_all_groups_has_no_effect(every_model: ht.Robot) -> None:
    """All phases together only shift the clock: their derivatives add up to nothing."""
    gait = fastest(every_model)
    found = ht.gradient(every_model, gait)
    by_phase = [k for k, name in enumerate(found.names) if name.startswith("gait.phase")]
    for name in ("speed", "cost_of_transport", "mechanical_power"):
        slopes = getattr(found, name)[by_phase]
        # the settled beat is only as independent of its clock as its steps are small
        assert abs(slopes.sum()) < 1e-3 * abs(slopes).sum()


def test_a_straight_gait_swims_slower_or_faster_whichever_way_it_is_bent(every_model: ht.Robot) -> None:
    """A bias and its mirror image do the same to the speed: at no bias the derivative along it vanishes."""
    gait = fastest(every_model)
    found = ht.gradient(every_model, gait)
    swim = ht.swim(every_model, gait)
    by_bias = [name.startswith("gait.bias") for name in found.names]
    assert sum(by_bias) == len(every_model.joints)
    assert abs(found.speed[by_bias]).max() < 1e-5 * swim.speed


def test_slopes_along_directions_are_combinations_of_all_derivatives(every_model: ht.Robot) -> None:
    """Of several gaits at once, more directions than lanes, and none at all."""
    gaits = Gaits.of([fastest(every_model), turning(every_model), turning(every_model, -0.1)])
    found = settle(every_model, gaits)
    count = len(parameter_names(every_model))
    whole = directional_derivatives(every_model, gaits, found, np.eye(count))
    directions = np.random.default_rng(0).normal(size=(count, 11))
    along = directional_derivatives(every_model, gaits, found, directions)
    nowhere = directional_derivatives(every_model, gaits, found, np.empty((count, 0)))
    assert along.keys() == whole.keys() == nowhere.keys()
    for name, slope in along.items():
        assert nowhere[name].shape == (3, 0)
        size = np.abs(whole[name]) @ np.abs(directions)
        np.testing.assert_array_less(np.abs(slope - whole[name] @ directions), 1e-11 * size, err_msg=name)


def test_slopes_of_another_model_are_that_model_s(tuna: ht.Robot) -> None:
    gaits = Gaits.of([fastest(tuna)])
    drag = [2 * drag for drag in tuna.water.lumped.drag]  # type: ignore[union-attr]
    by_all = np.eye(len(parameter_names(tuna)))
    model = core_model(tuna, {"water.lumped.drag": drag})
    here = directional_derivatives(tuna, gaits, settle(tuna, gaits, model=model), by_all, model=model)
    written = changed(tuna, {"water.lumped.drag": drag})
    there = directional_derivatives(written, gaits, settle(written, gaits), by_all)
    assert all(np.array_equal(here[name], there[name]) for name in here)


def test_gaits_without_derivatives_leave_the_others_theirs(tuna: ht.Robot) -> None:
    """One does not settle; and a body at rest keeps every disturbance as it is, so that I - dP1/dP0 is singular."""
    still = replace(fastest(tuna), amplitude=(0.0, 0.0))
    gaits = Gaits.of([fastest(tuna), turning(tuna), still])
    found = settle(tuna, gaits)
    found["status"][1] = STATUSES.index("unsettled")
    by_all = directional_derivatives(tuna, gaits, found, np.eye(len(parameter_names(tuna))))
    alone = ht.gradient(tuna, fastest(tuna))
    assert np.array_equal(by_all["speed"][0], alone.speed)
    assert np.isnan(by_all["speed"][1]).all()


def test_a_gait_that_does_not_settle_has_no_derivatives() -> None:
    robot = MODELS["hypertuna-lumped"]
    stiff = changed(robot, {"water.lumped.drag": [1e6] * len(robot.links.name)})
    with pytest.raises(ht.InputError, match=r"gait must settle to have derivatives, but is \w+: "):
        ht.gradient(stiff, fastest(stiff), steps=8)
