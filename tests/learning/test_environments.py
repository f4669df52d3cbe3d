"""Environments for learning: strangers' checkers, one swimmer as one of many, and tasks that can be checked by hand."""

import copy
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import NormalizeObservation, NormalizeReward, RecordEpisodeStatistics

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.errors import InputError
from hypertuna.learning.environments import SwimmerEnv, SwimmerVectorEnv
from hypertuna.learning.policy import plain_pilot, read_policy, success_rate
from hypertuna.learning.spans import STEP, knobs
from hypertuna.learning.swimmers import Swimmers
from hypertuna.learning.tasks import TASKS, Goto, Seen, Station, Swim, Turn
from hypertuna.simulation.estimates import random_robots

ROBOT = ht.load("hypertuna")


class Early(Swim):
    """A task whose episodes end when the goal is above the speed by much: sooner or later, by the goal."""

    def outcome(self, goal: Any, seen: Seen, before: Seen) -> Any:
        """Judge a step."""
        result = super().outcome(goal, seen, before)
        return result._replace(done=goal[:, 0] < 0.6)


TUNA = "examples/learning/goto.npz"


@pytest.mark.parametrize("name", TASKS)
def test_gymnasium_finds_nothing_to_complain_of(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(f"hypertuna/{name}-v0").unwrapped)


@pytest.mark.parametrize("name", TASKS)
def test_stable_baselines_finds_nothing_to_complain_of(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="needs Stable-Baselines3 and PyTorch")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gymnasium.make(f"hypertuna/{name}-v0").unwrapped)


def test_a_twin_that_leaves_what_a_robot_can_do_is_lost_among_its_neighbors() -> None:
    document = ROBOT.document()
    document["links"]["lateral_area_m2"][-1] = 1e12
    swimmers = Swimmers(Swim(), ROBOT, 8, robots=[ROBOT, parse(document)])
    assert not swimmers.lost.any()
    swimmers.act(np.full((8, 6), 0.5))
    assert 0 < swimmers.lost.sum() < 8
    kept = swimmers._columns["x"][~swimmers.lost]
    assert (np.abs(kept) < ROBOT.body.length).all()
    swimmers.restart(range(8), [np.random.default_rng(0)] * 8)
    assert not swimmers.lost.any()


def test_the_registered_vector_environment_is_the_native_one() -> None:
    env = gymnasium.make_vec("hypertuna/Goto-v0", num_envs=3)
    assert isinstance(env.unwrapped, SwimmerVectorEnv)
    assert env.observation_space.shape == (3, *env.single_observation_space.shape)
    assert knobs(ROBOT) == ("frequency", "amplitude of I", "amplitude of II", "lag of II", "bias of I", "bias of II")


def test_a_swimmer_alone_makes_the_steps_that_it_makes_among_others() -> None:
    one, many = SwimmerEnv("Swim"), SwimmerVectorEnv(11, "Swim", threads=2)
    one.reset(seed=4)
    many.reset(seed=4)
    many.swimmers.goal[:] = one.swimmers.goal
    actions = np.random.default_rng(0).uniform(-1, 1, (30, one.action_space.shape[0]))
    for action in actions:
        alone = one.step(action)
        together = many.step(np.tile(action, (11, 1)))
        np.testing.assert_array_equal(together[0][0], alone[0])  # the first has the same seed
        assert together[1][0] == alone[1]
    assert (together[0][1] != together[0][0]).any()  # others have other seeds


def test_a_seed_repeats_an_episode() -> None:
    def episode() -> list[float]:
        env = SwimmerVectorEnv(2, "Station")
        rewards = [env.reset(seed=7)[0].sum()]
        return rewards + [float(env.step(np.full((2, 6), 0.3))[1].sum()) for _ in range(20)]

    assert episode() == episode()


def test_an_episode_that_ends_shows_its_last_observation_and_begins_anew() -> None:
    env = SwimmerVectorEnv(2, Swim(seconds=0.3))
    env.reset(seed=1)
    for _ in range(3):
        observation, _, done, cut, infos = env.step(np.ones((2, 6)))
        assert (infos["_is_success"] != cut).all()
    assert infos["final_info"]["_is_success"].all()
    assert cut.all()
    assert not done.any()
    assert (infos["final_obs"] != observation).any()
    assert (env.swimmers.steps == 0).all()
    np.testing.assert_allclose(observation[:, 2 + 4 : 2 + 4 + 6], np.tile(env.swimmers.rest, (2, 1)))


def test_a_robot_at_rest_is_carried_by_the_current() -> None:
    env = SwimmerVectorEnv(3, "Station")
    env.reset(seed=2)
    for _ in range(50):
        env.step(np.tile(env.swimmers.rest, (3, 1)))
    drift = 50 * STEP * env.swimmers.current
    np.testing.assert_allclose(env.swimmers.seen.position, drift, atol=2e-3)
    assert np.linalg.norm(drift, axis=1).max() > 0.5


def seen(position: tuple[float, float], heading: float, speed: float = 0.0) -> Seen:
    return Seen(np.array([position]), np.array([heading]), np.array([speed]), np.array([0.5]))


def test_tasks_by_hand() -> None:
    still = np.zeros((1, 2))
    at, before, goal = seen((1, 1), np.pi / 2), seen((1, 0), np.pi / 2), np.array([[1.0, 5.0]])
    np.testing.assert_allclose(Goto().observe(goal, at, still), [[1, 0, 1]], atol=1e-12)  # straight ahead, 4 BL
    np.testing.assert_allclose(
        Goto().observe(np.array([[-1.0, 1]]), at, still), [[0, 1, 0.5]], atol=1e-12
    )  # to the left
    assert Goto().outcome(goal, at, before).reward == pytest.approx(1 - 0.05)  # a length nearer, half the power
    reached = Goto().outcome(np.array([[1.0, 1.3]]), at, before)
    assert reached.done
    assert reached.success
    error = Turn().observe(np.array([[-np.pi / 2]]), at, still)
    np.testing.assert_allclose(error, [[-1, 0]], atol=1e-12)
    assert Turn().outcome(np.array([[-np.pi / 2]]), at, before).reward == pytest.approx(-1 - 0.05)
    np.testing.assert_allclose(
        Station().observe(np.zeros((1, 2)), at, np.array([[0.0, 0.3]]))[:, 3:], [[0.3, 0]], atol=1e-12
    )
    assert Swim().outcome(np.array([[0.5]]), seen((0, 0), 0, 0.4), before).reward == pytest.approx(-0.1 - 0.05)


def test_speed_and_effort_are_those_of_the_twin() -> None:
    env = SwimmerEnv("Swim")
    env.reset(seed=1)
    swimmers, positions, efforts = env.swimmers, [], []
    for _ in range(60):
        env.step(np.array([-0.5, 0.0, 0.0, -0.3, 0.0, 0.0]))
        positions.append(swimmers.seen.position[0])
        efforts.append(swimmers.effort[0])
    frequency, amplitude, phase, bias = swimmers.span.gait(swimmers.action)
    gait = ht.Gait(frequency[0], tuple(amplitude[0]), tuple(phase[0]), tuple(bias[0]))
    run = ht.twin(ROBOT, gait, duration=6.01, seed=0)
    place = np.array([run.data["x"][600], run.data["y"][600]]) / ROBOT.body.length
    np.testing.assert_allclose(positions[-1], place, atol=0.08)  # sensors differ by their seeds: six twins by 0.06
    power = run.data["power"][:600].mean() / swimmers.power
    assert np.mean(efforts) == pytest.approx(power, rel=0.02)


def test_effort_is_a_part_of_the_power_of_all_four_pumps_at_stall() -> None:
    assert SwimmerEnv("Swim").swimmers.power == pytest.approx(4 * 7.4 * 7.0)  # count, voltage and current of its pumps


def test_robots_are_drawn_at_each_start() -> None:
    robots = random_robots(ROBOT, 3, seed=1)
    env = SwimmerVectorEnv(8, "Swim", robots=robots)
    env.reset(seed=3)
    for _ in range(20):
        env.step(np.tile([0.0, 0.5, 0.5, 0.0, 0.0, 0.0], (8, 1)))
    speeds = np.unique(env.swimmers.seen.speed.round(4))
    assert len(speeds) >= 3
    assert ROBOT.document() != robots[0].document() != robots[1].document()


def test_servos_on_axles_have_efforts_and_rewards() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("hypertuna/Swim-v0", robot="examples/servofish.toml").unwrapped)
    env = SwimmerVectorEnv(4, "Goto", robot="examples/servofish.toml")
    servos = [joint["servo"] for joint in ht.load("examples/servofish.toml").document()["joints"]]
    power = sum(servo["torque_n_m"] * servo["speed_rad_s"] for servo in servos)  # at stall: motors without losses
    assert env.swimmers.power == pytest.approx(power)
    env.reset(seed=1)
    for _ in range(20):
        _, reward, _, _, _ = env.step(np.tile([-0.5, 0.5, 0.5, 0.0, 0.0, 0.0], (4, 1)))
        assert (np.abs(reward) < 1).all()
        assert (env.swimmers.effort > 0).all()
        assert (env.swimmers.effort < 1).all()
    document = ROBOT.document()
    del document["servos"][1]["stall_current_a"], document["sources"]
    with pytest.raises(InputError, match=r"servos\[1\].stall_current_a is missing"):
        SwimmerEnv("Swim", robot=parse(document))


def test_a_twin_that_is_lost_has_a_reward_and_no_other_has_that_of_none() -> None:
    document = ROBOT.document()
    document["links"]["lateral_area_m2"][-1] = 1e12
    env = SwimmerVectorEnv(8, "Goto", robots=[ROBOT, parse(document)])
    env.reset(seed=1)
    _, reward, done, _, _ = env.step(np.full((8, 6), 0.5))
    assert 0 < done.sum() < 8
    assert (reward[done] == -10).all()
    assert (np.abs(reward[~done]) < 1).all()


def test_actions_of_a_wrong_shape_are_refused_before_anything_changes() -> None:
    one, many = SwimmerEnv("Swim"), SwimmerVectorEnv(2, "Swim")
    for env, wrong in (
        (one, [np.zeros(5), np.zeros((1, 6)), 0.0]),
        (many, [np.zeros(6), np.zeros((2, 7)), [[0.0] * 6]]),
    ):
        env.reset(seed=1)
        for action in wrong:
            with pytest.raises(InputError, match="action must be 6 numbers for each swimmer, but is of shape"):
                env.step(action)
        observation, *_ = env.step(np.zeros(env.action_space.shape))
        assert np.isfinite(observation).all()


@pytest.mark.parametrize("mode", AutoresetMode)
def test_vectors_are_those_of_gymnasium(mode: AutoresetMode) -> None:
    """Beside Gymnasium's own vector of single environments, whose episodes end one after another: to the last bit."""
    theirs = SyncVectorEnv([lambda: SwimmerEnv(Early(seconds=0.4))] * 3, autoreset_mode=mode)
    ours: Any = gymnasium.make_vec("hypertuna/Swim-v0", num_envs=3, task=Early(seconds=0.4), autoreset_mode=mode.value)
    assert theirs.metadata["autoreset_mode"] == ours.metadata["autoreset_mode"] == mode
    first, second = (env.reset(seed=[4, 9, 6])[0] for env in (theirs, ours))
    np.testing.assert_array_equal(first, second)
    ends = []
    for _ in range(12):
        actions = np.random.default_rng(len(ends)).uniform(-1, 1, (3, 6)).astype(np.float32)
        (*wanted, expected), (*got, infos) = (env.step(actions) for env in (theirs, ours))
        for one, other in zip(wanted, got, strict=True):  # a list seeds each swimmer, also of the episodes that follow
            np.testing.assert_array_equal(other, one)
        ended = got[2] | got[3]
        ends.append(ended)
        assert (
            ("final_info" in infos) == ("final_info" in expected) == (mode == AutoresetMode.SAME_STEP and ended.any())
        )
        if "final_info" in expected:
            np.testing.assert_array_equal(infos["final_obs"][ended], np.stack(expected["final_obs"][ended]))
            np.testing.assert_array_equal(infos["_final_obs"], expected["_final_obs"])
            np.testing.assert_equal(infos["final_info"], expected["final_info"])
        np.testing.assert_array_equal(infos["_is_success"], expected.get("_is_success", np.zeros(3, dtype=bool)))
        np.testing.assert_array_equal(infos["is_success"], expected.get("is_success", np.zeros(3, dtype=bool)))
        if mode == AutoresetMode.DISABLED and ended.any():
            resets = [env.reset(options={"reset_mask": ended})[0] for env in (theirs, ours)]
            np.testing.assert_array_equal(*resets)
    assert len({tuple(ended) for ended in ends}) > 2  # they end at different times


def test_wrappers_of_gymnasium_take_the_mode_that_they_need() -> None:
    env: Any = gymnasium.make_vec("hypertuna/Swim-v0", num_envs=3, autoreset_mode=AutoresetMode.NEXT_STEP)
    wrapped = RecordEpisodeStatistics(NormalizeReward(NormalizeObservation(env)))
    wrapped.reset(seed=1)
    lengths = []
    for _ in range(103):
        *_, infos = wrapped.step(env.action_space.sample())
        lengths += infos["episode"]["l"][infos["_episode"]].tolist() if "episode" in infos else []
    assert lengths == [100] * 3


def test_an_ended_episode_must_be_reset_without_autoreset() -> None:
    env = SwimmerVectorEnv(2, Swim(seconds=0.2), autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=1)
    for _ in range(2):
        *_, cut, _ = env.step(np.zeros((2, 6)))
    assert cut.all()
    with pytest.raises(InputError, match=r"swimmers must be reset after an episode ends, but is \[0, 1\]: call reset"):
        env.step(np.zeros((2, 6)))
    env.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(InputError, match=r"is \[1\]: call reset"):
        env.step(np.zeros((2, 6)))
    for mask in ([True], np.zeros(2, dtype=bool), np.ones(2)):
        with pytest.raises(InputError, match="reset_mask must be 2 truths, one at least true"):
            env.reset(options={"reset_mask": mask})


# --- states


@pytest.mark.parametrize("mode", AutoresetMode)
def test_a_restored_environment_has_the_same_future(mode: AutoresetMode) -> None:
    """To the last bit, through ends of episodes with new goals, robots and seeds: restored twice, and in a copy."""
    robots = random_robots(ROBOT, 3, seed=1)
    env = SwimmerVectorEnv(11, Station(seconds=0.7), robots=robots, threads=2, autoreset_mode=mode)
    env.reset(seed=3)
    for _ in range(5):
        env.step(env.action_space.sample())
    state, copied = env.save_state(), copy.deepcopy(env)
    actions = np.random.default_rng(0).uniform(-1, 1, (20, *env.action_space.shape))

    def future(one: SwimmerVectorEnv) -> list[Any]:
        seen: list[Any] = []
        for action in actions:
            *step, _ = one.step(action)
            seen += step
            if mode == AutoresetMode.DISABLED and (ended := step[2] | step[3]).any():
                seen.append(one.reset(options={"reset_mask": ended})[0])
        return seen

    first = future(env)
    np.testing.assert_equal(future(copied), first)
    assert any(not np.array_equal(*pair) for pair in zip(future(env), first, strict=True))  # it has gone on
    for one in (env, env, copied):
        one.restore_state(state)
        np.testing.assert_equal(future(one), first)


def test_one_swimmer_plans_by_its_states() -> None:
    """The best of some futures comes true. Under Gymnasium's wrappers, by `unwrapped`, or in a copy of all."""
    env = gymnasium.make("hypertuna/Goto-v0")
    env.reset(seed=5)
    plain: Any = env.unwrapped
    plans = np.random.default_rng(1).uniform(-1, 1, (4, 8, 6))

    def reward(plan: Any, one: Any) -> list[float]:
        return [float(one.step(action)[1]) for action in plan]

    state = plain.save_state()
    foreseen = []
    for plan in plans:
        plain.restore_state(state)
        foreseen.append(reward(plan, plain))
    plain.restore_state(state)
    best = int(np.argmax(np.sum(foreseen, axis=1)))
    assert reward(plans[best], copy.deepcopy(env)) == foreseen[best]
    assert reward(plans[best], env) == foreseen[best]
    assert len({tuple(one) for one in foreseen}) == 4


def test_a_state_is_of_the_same_environment() -> None:
    state = SwimmerVectorEnv(2, "Swim").save_state()
    SwimmerVectorEnv(2, "Swim").restore_state(state)
    document = ROBOT.document()
    document["links"]["lateral_area_m2"][0] *= 1.1
    for arguments in ({"num_envs": 3}, {"task": "Turn"}, {"step": 0.2}, {"robot": parse(document)}):
        other = SwimmerVectorEnv(**({"num_envs": 2, "task": "Swim"} | arguments))
        with pytest.raises(InputError, match="state must be of an environment of the same task, robots, number and st"):
            other.restore_state(state)


def test_seeds_of_a_list_are_one_for_each_swimmer() -> None:
    env = SwimmerVectorEnv(3, "Goto")
    first, _ = env.reset(seed=[1, 2, 1])
    np.testing.assert_array_equal(first[0], first[2])
    assert (first[0] != first[1]).any()
    again, _ = env.reset(seed=[None, 2, None])
    np.testing.assert_array_equal(again[1], first[1])
    assert (again[0] != first[0]).any()
    for wrong in ([], [1], [1, 2, 3, 4]):
        with pytest.raises(InputError, match="seed must be one for each of 3 swimmers"):
            env.reset(seed=wrong)


def test_stable_baselines_uses_a_seed_once() -> None:
    pytest.importorskip("stable_baselines3", reason="needs Stable-Baselines3 and PyTorch")
    from hypertuna.learning.sb3 import Sb3VecEnv

    env = Sb3VecEnv(2, Swim(seconds=0.1))
    env.seed(3)
    first, second = env.reset(), env.reset()
    assert (first != second).any()
    env.seed(3)
    np.testing.assert_array_equal(env.reset(), first)
    *_, infos = env.step(np.zeros((2, 6)))
    assert [info["TimeLimit.truncated"] for info in infos] == [True, True]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": float("nan")}, "step must be a finite number"),
        ({"step": float("inf")}, "step must be a finite number"),
        ({"step": "a"}, "step must be a finite number"),
        ({"autoreset_mode": "never"}, "autoreset_mode must be NextStep, SameStep or Disabled, but is 'never'"),
        ({"threads": 0}, "threads must be at least 1"),
        ({"threads": -3}, "threads must be at least 1"),
        ({"robots": ["examples/servofish.toml"]}, "robots must have the links, joints and water law of hypertuna"),
    ],
)
def test_arguments_are_checked(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        SwimmerVectorEnv(2, "Swim", **options)


def test_robots_go_by_name_and_frames_by_the_step() -> None:
    env = SwimmerEnv("Swim", robots=["hypertuna"], step=0.5)
    assert env.reset(seed=1)[0].shape == env.observation_space.shape
    assert env.metadata["render_fps"] == SwimmerVectorEnv(1, "Swim", step=0.5).metadata["render_fps"] == 2
    with pytest.raises(InputError, match="task must be"):
        SwimmerEnv(Goto)  # the class


def test_what_a_robot_lacks_is_told() -> None:
    document = ROBOT.document()
    del document["joints"][1]["bend_max_deg"]
    with pytest.raises(InputError, match=r"joints.II.bend_max_deg is needed to learn"):
        SwimmerEnv("Swim", robot=parse(document))
    with pytest.raises(InputError, match="task must be"):
        SwimmerEnv("Fly")


def test_the_plain_pilot_reaches_points() -> None:
    env = SwimmerVectorEnv(8, "Goto", threads=2)
    result = success_rate(env, plain_pilot(env.swimmers), episodes=8, seed=1)
    assert result["episodes"] == 8
    assert result["success"] == 1


def test_policies_that_are_none_are_refused(tmp_path: Path) -> None:
    for name, arrays in (
        ("empty", {}),
        (
            "shape",
            {"weight0": np.zeros((3, 2)), "bias0": np.zeros(3), "weight1": np.zeros((1, 4)), "bias1": np.zeros(1)},
        ),
        ("nan", {"weight0": np.full((3, 2), np.nan), "bias0": np.zeros(3)}),
    ):
        np.savez(tmp_path / f"{name}.npz", **arrays)
        with pytest.raises(InputError, match=f"{name}.npz"):
            read_policy(tmp_path / f"{name}.npz")
    assert read_policy(TUNA).step == 0.5
    assert read_policy(TUNA).task == "Goto"
    layer = {"weight0": np.zeros((3, 2)), "bias0": np.zeros(3)}
    np.savez(tmp_path / "step.npz", **layer, step=-1.0)
    with pytest.raises(InputError, match=r"step.npz: step must be greater than 0"):
        read_policy(tmp_path / "step.npz")
    with pytest.raises(InputError, match="must be a file, but is missing"):
        read_policy(tmp_path / "none.npz")


def test_the_core_is_not_slowed_by_the_extra() -> None:
    assert "hypertuna.learning" in sys.modules
    import subprocess

    code = "import sys, hypertuna; hypertuna.load('hypertuna'); assert 'gymnasium' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
