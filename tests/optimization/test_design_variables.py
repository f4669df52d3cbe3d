"""Numbers of a robot's file as variables: exact derivatives, what follows a length, optima, limits, bad input."""

from __future__ import annotations

import functools
import math
import tomllib
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.description.design import designed, variable
from hypertuna.description.new import new_robot
from hypertuna.description.robot import Robot, parse
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import gait_limits
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import objective
from hypertuna.optimization.optimum import _on_bounds
from hypertuna.optimization.problem import Problem
from hypertuna.swimming.beat import settle
from hypertuna.swimming.designs import beat_features, rates
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model
from models import changed

BOUNDS = {"frequency": (1.0, 3.0), "amplitude": (5.0, 20.0), "phase": (0.0, 90.0)}


@functools.cache
def robot_named(name: str) -> Robot:
    """A shipped robot in a water law, or a new fish, with a hinge at its last link or without."""
    base, _, rest = name.partition(" ")
    robot = parse(new_robot("fish", links=4, length=0.35)) if base == "new" else ht.load(base)
    if "strip" in rest:
        robot = robot.using(water="strip")
    robot = hinged(robot) if "hinge" in rest else robot
    return changed(robot, {"hinge.rest_deg": 4.0, "hinge.cubic_n_m_per_rad3": 2.0}) if "bent" in rest else robot


def hinged(robot: Robot, ratio: float = 1.7, frequency: float = 2.5) -> Robot:
    """A robot with a hinge at its last link, of a stiffness over that at resonance."""
    link = len(robot.links.name) - 1
    inertia = _core.hinge_inertia(core_model(robot), [link])[0, 0]
    stiffness = ratio * inertia * (2 * math.pi * frequency) ** 2
    hinge = {"link": link, "stiffness_n_m_per_rad": stiffness}
    return parse(robot.document() | {"hinge": hinge | {"damping_n_m_s_per_rad": 0.1 * math.sqrt(stiffness * inertia)}})


KEYS = {
    "hypertuna": (
        "links.length[7]",
        "links.mass[0]",
        "links.com[7]",
        "water.lumped.drag[7]",
        "joints.II.bandwidth",
        "fin.area",
        "fin.aspect_ratio",
    ),
    "hypertuna strip": ("links.mass[7]", "fin.span", "fin.chord", "links.inertia_kg_m2[7]", "water.density"),
    "hypertuna strip hinge": ("hinge.stiffness", "fin.span"),
    "rexeel": ("links.length[1]", "links.lateral_area[2]"),
    "new": ("links.length[0]", "fin.area", "water.strip.blunt_area_m2[0]", "joints.J1.phase_offset"),
    "new hinge bent": ("hinge.rest", "hinge.cubic"),
    "new hinge": ("hinge.stiffness", "hinge.damping_n_m_s_per_rad", "fin.aspect_ratio", "links.mass[3]"),
}


@pytest.mark.parametrize(("name", "key"), [(name, key) for name, keys in KEYS.items() for key in keys])
def test_derivatives_by_a_number_of_the_file_equal_differences(name: str, key: str) -> None:
    """To 1e-6 of the value over the number; objectives and limits, those of mass and length too."""
    robot = robot_named(name)
    near = {"joints.J1.phase_offset": (-5.0, 6.0), "fin.aspect_ratio": (0.93, 0.99)}
    value = variable(robot, key, 0.9, 1.1).value if key.startswith("fin") else value_of(robot, key)
    ends = near.get(key, (0.94 * value, 1.07 * value))
    space = gait_bounds(robot, BOUNDS, {key: ends})
    targets = tuple(objective(name) for name in ("speed", "cost_of_transport", "speed_bl"))
    limits = gait_limits(robot, joint_rate=5, torque=1, strouhal=(0.2, 0.4), mass=3, length=1)
    problem = Problem(robot, space, targets, limits)
    x = space.lower + 0.63 * (space.upper - space.lower)
    found = problem.evaluate(x[np.newaxis], derivatives=True)
    assert found.value_jacobian is not None
    assert found.violation_jacobian is not None
    step = 1e-3 * (ends[1] - ends[0])

    def values(factor: float) -> Any:
        at = x.copy()
        at[-1] += factor * step
        one = problem.evaluate(at[np.newaxis])
        return np.concatenate([one.value[0], one.violation[0] + 1])

    differences = (8 * (values(1) - values(-1)) - (values(2) - values(-2))) / (12 * step)
    exact = np.concatenate([found.value_jacobian[0, :, -1], found.violation_jacobian[0, :, -1]])
    scale = np.abs(values(0)) / (abs(value) or 1.0)
    peak = [limit.quantity == "torque_peak" for limit in problem.limits]  # has a kink where two peaks are equal
    smooth = np.append([True] * 3, np.logical_not(peak) if key.endswith("phase_offset") else [True] * len(peak))
    assert (np.abs(exact - differences) <= 1e-6 * scale)[smooth].all()
    assert np.abs(exact[:3]).max() > 1e-9 * scale.max()


def value_of(robot: Robot, key: str) -> float:
    """The value of a key, from any range that is accepted."""
    for low, high in ((0.002, 0.003), (1e-4, 2e-4), (1.0, 2.0), (900.0, 1100.0)):
        try:
            return variable(robot, key, low, high).value
        except InputError:
            continue
    raise AssertionError(key)


def test_what_follows_a_length_is_that_of_a_file_changed_by_hand(tuna: Robot) -> None:
    """Center of mass, areas and sums in proportion, the moment of inertia as the square; the mass stays."""
    links, factor = tuna.links, 1.2
    by_hand = tuna.document()
    by_hand["links"]["length_m"][7] = 0.089 * factor
    by_hand["links"]["com_m"][7] = 0.0313 * factor
    by_hand["links"]["lateral_area_m2"][7] = 0.00511 * factor
    by_hand["links"]["wetted_area_m2"][7] = 0.01154 * factor
    by_hand["spatial"]["buoyancy_center_m"][7] = 0.0313 * factor
    by_hand["body"]["length_m"] += 0.089 * (factor - 1)
    one = variable(tuna, "links.length[7]", 0.08, 0.12)
    found = designed(tuna, (one,), (0.089 * factor,))
    np.testing.assert_allclose(beat_features(found), beat_features(parse(by_hand)), rtol=1e-14)
    assert found.links.inertia[7] == pytest.approx(links.inertia[7] * factor**2, rel=1e-14)
    assert found.links.mass == links.mass
    assert (one.unit, one.value) == ("m", 0.089)


def test_a_mass_takes_moment_of_inertia_and_sum_with_it(tuna: Robot) -> None:
    found = designed(tuna, (variable(tuna, "links.mass_kg[0]", 2, 3),), (2.4,))
    assert found.body.mass == pytest.approx(3.3 + 2.4 - 2.209, rel=1e-15)
    assert found.links.inertia[0] == pytest.approx(tuna.links.inertia[0] * 2.4 / 2.209, rel=1e-14)


def test_values_that_a_file_leaves_to_defaults_can_be_varied_and_follow() -> None:
    document = new_robot("fish", links=3, length=0.3)
    for key in ("com_m", "wetted_area_m2", "inertia_kg_m2"):
        document["links"].pop(key, None)
    document["sources"] = {}
    document.pop("uncertainty", None)
    plain = parse(document)
    one = variable(plain, "links.com_m[1]", 0.02, 0.04)
    found = designed(plain, (one,), (0.03,))
    assert found.links.com == (plain.links.com[0], 0.03, plain.links.com[2])
    longer = designed(plain, (variable(plain, "links.length[1]", 0.05, 0.1),), (0.1,))
    assert longer.links.com[1] == 0.05
    assert longer.links.inertia[1] == pytest.approx(plain.links.mass[1] * 0.1**2 / 12, rel=1e-14)
    damped = robot_named("hypertuna strip hinge")
    document = damped.document()
    del document["hinge"]["damping_n_m_s_per_rad"]
    free = parse(document)
    found = designed(free, (variable(free, "hinge.damping", 1e-4, 1e-2),), (2e-3,))
    assert found.hinge is not None
    assert found.hinge.damping == 2e-3


def test_none_of_a_value_is_a_value_of_a_design() -> None:
    """An undamped hinge is described by 0, which no usual range holds."""
    robot = springy()
    assert variable(robot, "hinge.damping", 0.0, 0.001).low == 0.0


@pytest.mark.parametrize("part", [0.0, 0.001, 0.5, 1.0])
def test_how_the_numbers_follow_is_known_to_ten_digits(tuna: Robot, part: float) -> None:
    """Powers of one half to two, inside the range and at its ends, against their derivatives on paper."""
    links = tuna.links

    def columns(robot: Robot) -> Any:
        strip = robot.water.strip
        assert strip is not None
        one = robot.links
        return np.array([one.com[7], one.inertia[7], one.lateral_area[7], strip.edge_height, strip.edge_aspect])

    length = variable(tuna, "links.length[7]", 0.05, 0.12)
    x = 0.05 + 0.07 * part
    (found,) = rates(tuna, (length,), np.array([x]), columns).T
    exact = (links.com[7] / 0.089, 2 * links.inertia[7] * x / 0.089**2, links.lateral_area[7] / 0.089, 0, 0)
    np.testing.assert_allclose(found, exact, rtol=1e-10, atol=1e-12)
    area = variable(tuna, "fin.area", 0.3, 1.7)
    x = 0.3 + 1.4 * part
    (found,) = rates(tuna, (area,), np.array([x]), columns).T
    np.testing.assert_allclose(found, (0, 0, 0.160 * 0.032, 0.5 * 0.160 / math.sqrt(x), 0), rtol=1e-10, atol=1e-11)


# --- optima


@functools.cache
def springy() -> Robot:
    """A fish of three links in quadratic water, one joint driven, a hinge at its last link."""
    document = new_robot("x", links=3, length=0.3, mass=0.85)
    document["joints"] = document["joints"][:1]
    for name in ("gaits", "gait_bounds"):
        del document[name], document["sources"][name]
    document["water"]["strip"]["drag_beating"] = [0.0, 0.0, 0.0]
    return hinged(parse(document), 1.6, 2.0)


def fixed(frequency: float) -> dict[str, tuple[float, float]]:
    """Bounds of one gait alone."""
    return {"frequency": (frequency,) * 2, "amplitude": (16.0, 16.0), "phase": (0.0, 0.0)}


def test_the_best_stiffness_is_that_of_a_fine_sweep() -> None:
    robot = springy()
    assert robot.hinge is not None
    k = robot.hinge.stiffness
    ends = (0.4 * k, 3 * k)
    best = ht.optimize(robot, maximize="speed", bounds=fixed(2.0), design={"hinge.stiffness": ends})
    gait = ht.Gait.from_degrees(frequency=2.0, amplitude=(16,), phase=(0,))
    levels = np.linspace(*ends, 2001)
    grid = ht.sweep(robot, [gait], design={"hinge.stiffness": levels.tolist()}).speed.values[:, 0]
    at = int(grid.argmax())
    (name,) = best.design
    assert name == "hinge.stiffness_n_m_per_rad"
    assert 0 < at < 2000
    curve = np.polyfit(levels[at - 1 : at + 2] - levels[at], grid[at - 1 : at + 2], 2)
    assert best.design[name] == pytest.approx(levels[at] - curve[1] / (2 * curve[0]), rel=1e-3)
    assert best.speed >= grid[at] * (1 - 1e-9)
    assert best.robot.hinge is not None
    assert best.robot.hinge.stiffness == best.design[name]
    assert best.method == "gradient"


def test_the_best_stiffness_grows_as_the_square_of_the_frequency() -> None:
    """Similarity in quadratic water, the damping in proportion to the frequency."""
    found = []
    for factor in (1.0, 2.0):
        robot = springy()
        assert robot.hinge is not None
        robot = changed(robot, {"hinge.damping_n_m_s_per_rad": robot.hinge.damping * factor})
        ends = (0.4 * robot.hinge.stiffness * factor**2, 3 * robot.hinge.stiffness * factor**2)
        best = ht.optimize(robot, maximize="speed", bounds=fixed(2 * factor), design={"hinge.stiffness": ends})
        found.append((best.design["hinge.stiffness_n_m_per_rad"], best.speed))
    assert found[1][0] / found[0][0] == pytest.approx(4, rel=1e-4)
    assert found[1][1] / found[0][1] == pytest.approx(2, rel=1e-8)


def test_a_limit_of_the_body_is_active_at_the_optimum(tuna: Robot) -> None:
    strip = tuna.using(water="strip")
    limits = gait_limits(strip, length=0.53)
    best = ht.optimize(strip, maximize="speed", design={"links.length[7]": (0.06, 0.12)}, limits=limits)
    free = ht.optimize(strip, maximize="speed", design={"links.length[7]": (0.06, 0.12)})
    assert best.robot.body.length == pytest.approx(0.53, rel=1e-6)
    assert [margin.active for margin in best.margins] == [True]
    assert free.speed > best.speed
    assert free.bounds["links.length_m[7]"] == "upper"


def test_the_bend_of_a_hinge_is_a_limit_without_derivatives() -> None:
    robot = springy()
    assert robot.hinge is not None
    k = robot.hinge.stiffness
    how: Any = {"maximize": "speed", "bounds": fixed(2.0), "design": {"hinge.stiffness": (0.5 * k, 20 * k)}}
    free = ht.optimize(robot, **how)
    assert free.gait is not None
    bend = float(settle(free.robot, Gaits.of([free.gait]))["bend_peak"][0])
    kept = ht.optimize(robot, **how, limits=gait_limits(robot, bend=0.8 * bend), particles=8, iterations=20)
    assert kept.method == "pso"
    assert kept.margins[0].limit.quantity == "bend_peak"
    assert 0 <= kept.margins[0].margin < 0.02
    assert kept.speed < free.speed


def test_each_hinge_has_a_limit() -> None:
    fish = parse(tomllib.loads(first_robot("x", tail="flexible")))
    limits = gait_limits(fish, bend=np.radians(12))
    assert [limit.quantity for limit in limits] == ["bend_peak_1", "bend_peak_2", "bend_peak_3"]
    how: Any = {"limits": limits, "bounds": {"frequency": (1.0, 2.0)}}
    best = ht.optimize(fish, maximize="speed", particles=4, iterations=3, **how)
    assert best.method == "pso"
    assert best.swim is not None
    assert max(bend.bend_peak for bend in best.swim.bends) < np.radians(12)
    assert len(ht.pareto(fish, population=8, generations=2, **how).x)


@pytest.mark.parametrize(
    ("key", "low", "high", "shift"), [("stiffness", 0.01, 900.0, 0.0), ("damping", 0.0, 10.0, 1e-4)]
)
def test_a_wide_range_is_searched_by_its_logarithm(key: str, low: float, high: float, shift: float) -> None:
    """From zero on, by that of the sum with the described value. Most points of such a range were refused.

    A value is on a bound within 0.5 % of itself, not of the range.
    """
    robot = changed(springy(), {"hinge.damping_n_m_s_per_rad": 1e-4})
    space = gait_bounds(robot, fixed(2.0), {f"hinge.{key}": (low, high)})
    for part, value in ((0.0, low), (1.0, high), (0.5, math.sqrt((low + shift) * (high + shift)) - shift)):
        x = space.lower + part * (space.upper - space.lower)
        assert space.design(x) == pytest.approx(value, rel=1e-12)
        assert low <= space.design(x)[0] <= high
    assert _on_bounds(space, space.lower + 0.01)[0].tolist() == [False]
    problem = Problem(robot, space, (objective("speed"),))
    x, h = space.lower + 0.3 * (space.upper - space.lower), 1e-4
    found = problem.evaluate(x[np.newaxis], derivatives=True)
    high_value, low_value = (problem.evaluate(x[np.newaxis] + side).value[0, 0] for side in (h, -h))
    assert found.value_jacobian is not None
    assert found.value_jacobian[0, 0] == pytest.approx((high_value - low_value) / (2 * h), rel=1e-5)
    best = ht.optimize(robot, maximize="speed", bounds=fixed(2.0), design={f"hinge.{key}": (low, high)}, particles=2)
    if key == "stiffness":
        near = ht.optimize(robot, maximize="speed", bounds=fixed(2.0), design={"hinge.stiffness": (0.02, 0.2)})
        assert best.design == pytest.approx(near.design, rel=1e-3)
    else:
        assert [*best.design.values()] == pytest.approx([0.0], abs=1e-12)  # the least damping
        assert best.bounds == {"hinge.damping_n_m_s_per_rad": "lower"}


def test_a_value_far_from_a_small_bound_is_not_on_it() -> None:
    """Of springs from 0.01 to 100 N m/rad the best has six times the lower end, though near it beside the range."""
    robot = springy()
    best = ht.optimize(robot, maximize="speed", bounds=fixed(2.0), design={"hinge.stiffness": (0.01, 100.0)})
    (stiffness,) = best.design.values()
    assert stiffness == pytest.approx(0.059, rel=0.01)
    assert "hinge.stiffness_n_m_per_rad" not in best.bounds


def test_a_search_whose_robots_are_all_refused_says_why() -> None:
    robot = springy()
    how: Any = {"bounds": fixed(0.5), "design": {"hinge.stiffness": (800.0, 900.0)}}
    sentence = "A robot of the search was refused: hinge.stiffness_n_m_per_rad must let 1024 steps"
    assert sentence in ht.optimize(robot, maximize="speed", particles=2, iterations=2, **how).stop
    how["bounds"] = {"frequency": (0.3, 0.5), "amplitude": (5.0, 16.0), "phase": (0.0, 0.0)}
    assert sentence in ht.pareto(robot, population=4, generations=1, **how).stop


def test_a_point_whose_file_would_be_refused_is_infeasible(tuna: Robot) -> None:
    """Each range is allowed alone, but not both ends together: the fin must fit its link."""
    strip = tuna.using(water="strip")
    space = gait_bounds(strip, fixed_pair(), {"fin.chord": (0.5, 2.5), "links.length[7]": (0.05, 0.12)})
    problem = Problem(strip, space, (objective("speed"),))
    found = problem.evaluate(np.array([[2.5, 0.05], [2.5, 0.12]]), derivatives=True)
    assert found.feasible.tolist() == [False, True]
    assert np.isinf(found.value[0, 0])


def fixed_pair() -> dict[str, tuple[float, float]]:
    """Bounds of one gait of two joint groups."""
    return {"frequency": (2.0, 2.0), "amplitude": (15.0, 15.0), "phase_I": (0.0, 0.0), "phase_II": (40.0, 40.0)}


def test_robots_of_a_fit_take_the_design_too(tuna: Robot) -> None:
    """Each sample swims with the values of the variables, the rest as drawn."""
    from hypertuna.optimization.problem import robust_problem

    other = changed(tuna, {"links.mass_kg": [2.5, *tuna.links.mass[1:]], "body.mass_kg": 3.6})
    space = gait_bounds(tuna, fixed_pair(), {"water.lumped.drag[7]": (10.0, 30.0)})
    problem = robust_problem(Problem(tuna, space, (objective("speed"),)), (tuna, other), "mean")
    found = problem.evaluate(np.array([[12.0]]))
    gait = space.gait([12.0])
    assert tuna.water.lumped is not None
    drags = [*tuna.water.lumped.drag[:7], 12.0]
    speeds = [ht.swim(changed(one, {"water.lumped.drag": drags}), gait).speed for one in (tuna, other)]
    assert -found.value[0, 0] == pytest.approx(np.mean(speeds), rel=1e-12)


def test_a_search_resumes_from_its_checkpoint_alone(tuna: Robot, tmp_path: Path) -> None:
    """A journal of other variables or bounds is that of another search."""
    how: Any = {"maximize": "speed", "bounds": fixed_pair(), "iterations": 3, "checkpoint": tmp_path / "search"}
    with ProcessPoolExecutor(1) as executor:
        first = ht.optimize(tuna, **how, design={"fin.area": (0.8, 1.2)}, executor=executor)
    again = ht.optimize(tuna, **how, design={"fin.area": (0.8, 1.2)})
    assert (again.design, again.speed) == (first.design, first.speed)
    for other in ({"fin.area": (0.8, 1.3)}, {"fin.span": (0.8, 1.2)}):
        with pytest.raises(InputError, match="bounds"):
            ht.optimize(tuna, **how, design=other)


def test_a_front_has_the_design_of_every_point() -> None:
    robot = springy()
    assert robot.hinge is not None
    k = robot.hinge.stiffness
    bounds = {"frequency": (1.0, 3.0), "amplitude": (5.0, 16.0), "phase": (0.0, 0.0)}
    front = ht.pareto(robot, bounds=bounds, design={"hinge.stiffness": (0.5 * k, 4 * k)}, population=8, generations=4)
    (stiffness,) = front.designs.values()
    assert len(stiffness) == len(front.x) > 3
    assert np.ptp(stiffness) > 0
    np.testing.assert_allclose(front.points["hinge.stiffness"], stiffness)
    np.testing.assert_allclose(front.points.speed, front.values[:, 0], rtol=1e-9)
    for one, gait, value in zip(front.robots, front.gaits, front.values, strict=True):
        assert ht.swim(one, gait).speed == pytest.approx(value[0], rel=1e-9)
    assert np.median(front.stationarity) < 1e-3


# --- sweeps


def test_a_sweep_over_a_design_swims_every_robot() -> None:
    robot = robot_named("hypertuna strip hinge")
    grid = ht.Gaits.grid_degrees(frequency=(2, 3), amplitude=[(16, 25)], phase=[(0, 40)])
    design = {"hinge.stiffness_n_m_per_rad": (0.3, 0.6, 0.9), "fin.area": (0.8, 1.2)}
    found = ht.sweep(robot, grid, design=design)
    assert list(found.sizes) == ["hinge.stiffness", "fin.area", "frequency", "amplitude", "phase", "bias"]
    assert found["hinge.stiffness"].attrs["units"] == "N m/rad"
    assert found.attrs["robot_hash"] == robot.hash
    variables = [variable(robot, key, min(values), max(values)) for key, values in design.items()]
    for (i, k), (j, area) in ((a, b) for a in enumerate((0.3, 0.6, 0.9)) for b in enumerate((0.8, 1.2))):
        alone = ht.sweep(designed(robot, variables, (k, area)), grid)
        for name in ("speed", "bend_peak", "status"):
            np.testing.assert_array_equal(found[name].values[i, j], alone[name].values)


def test_a_limit_of_a_hinge_needs_one(tuna: Robot) -> None:
    with pytest.raises(InputError, match="passive hinge, which the robot lacks"):
        gait_limits(tuna, bend=0.5)


def test_a_spring_of_a_chain_has_the_name_of_its_derivative() -> None:
    fish = parse(tomllib.loads(first_robot("x", tail="flexible")))
    one = variable(fish, "hinges[1].stiffness", 0.01, 0.1)
    assert (one.label, one.name) == ("hinges[1].stiffness", "hinges[1].stiffness_n_m_per_rad")
    with pytest.raises(ht.InputError, match=r"did you mean hinges\[1\].stiffness\?"):
        variable(fish, "hinges[1].stifness", 0.01, 0.1)


def test_values_of_a_sweep_must_differ(tuna: Robot) -> None:
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(16, 25), phase=(0, 40))
    for values in ((1.0,), (1.0, 1.0, 2.0)):
        with pytest.raises(InputError, match="must be different values"):
            ht.sweep(tuna, [gait], design={"fin.area": values})
    with pytest.raises(InputError, match="must be finite"):
        ht.sweep(tuna, [gait], design={"fin.area": (1.0, math.nan)})
