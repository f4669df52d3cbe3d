"""A policy on the emulated Cortex-M7: the actions of the network, the gaits that they mean, within the tick."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.errors import InputError

pytest.importorskip("gymnasium")

from hypertuna.learning.header import policy_header
from hypertuna.learning.policy import Policy, read_policy
from hypertuna.learning.spans import span_of

TOP = Path(__file__).parents[2]
ROBOT = ht.load("hypertuna")
TRAINED = TOP / "examples" / "learning" / "goto.npz"
TICK = 250_000 * 40 // 64  # instructions of a control tick on the emulated board


def test_a_policy_on_the_board_acts_as_the_trained_network(tmp_path: Path) -> None:
    for program in ("arm-none-eabi-g++", "qemu-system-arm"):
        if shutil.which(program) is None:
            pytest.skip(f"needs {program}")
    header = tmp_path / "policy.hpp"
    made = CliRunner().invoke(app, ["rl", "export", str(TRAINED), "--robot", "hypertuna", "-o", str(header)])
    assert made.exit_code == 0, made.output
    board = TOP / "firmware" / "boards" / "qemu_mps2"
    options = (f"-DCMAKE_TOOLCHAIN_FILE={board}/toolchain.cmake", f"-DHYPERTUNA_POLICY={header}")
    build = ("cmake", "-S", TOP, "-B", tmp_path / "b", "-G", "Ninja", "-DHYPERTUNA_BUILD_FIRMWARE=ON", *options)
    subprocess.run(build, check=True, capture_output=True)
    subprocess.run(("cmake", "--build", tmp_path / "b", "--target", "policy"), check=True, capture_output=True)
    (program,) = (tmp_path / "b").rglob("policy.elf")

    policy, rng = read_policy(TRAINED), np.random.default_rng(1)
    observations = rng.uniform(-1.5, 1.5, (200, policy.weights[0].shape[1])).astype(np.float32)
    observations[::10] *= 2.6  # some near the bounds of an observation
    (tmp_path / "observations").write_bytes(observations.tobytes())
    machine = ("-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=6")
    hosting = ("-semihosting-config", "enable=on,target=native", "-kernel", program)
    subprocess.run(("qemu-system-arm", *machine, *hosting), cwd=tmp_path, check=True, timeout=120)

    actions, joints = policy(observations), len(ROBOT.joints)
    width = actions.shape[1] + 1 + 3 * joints
    rows = np.frombuffer((tmp_path / "actions").read_bytes(), np.dtype([("numbers", "<f4", width), ("count", "<u4")]))
    assert len(rows) == len(observations)
    np.testing.assert_allclose(rows["numbers"][:, : actions.shape[1]], actions, atol=1e-6, rtol=0)
    frequency, *angles = span_of(ROBOT).gait(actions)
    gaits = np.concatenate([frequency[:, np.newaxis], *angles], axis=1)
    np.testing.assert_allclose(rows["numbers"][:, actions.shape[1] :], gaits, atol=1e-5, rtol=0)
    instructions = rows["count"].max() * 40 / 64
    assert 5_000 < instructions < TICK / 3, instructions


def test_the_header_has_every_weight_and_refuses_what_does_not_fit() -> None:
    rng = np.random.default_rng(2)
    policy = Policy((rng.normal(size=(3, 2)), rng.normal(size=(6, 3))), (np.zeros(3), np.ones(6)))
    text = policy_header(policy, ROBOT, "my.npz")
    assert "{2, 3, weight_0, bias_0}, {3, 6, weight_1, bias_1}" in text
    assert f"{policy.weights[0][2, 1]:.9g}f" in text
    assert "bias_1[] = {1.0f, 1.0f" in text
    assert "    2, policy_numbers::layers, 10, 2," in text
    assert "    2, policy_numbers::layers, 50, 2," in policy_header(policy, ROBOT, "my.npz", step=0.5)
    with pytest.raises(InputError, match="step must be whole control ticks of 0.01 s"):
        policy_header(policy, ROBOT, "my.npz", step=0.005)
    with pytest.raises(InputError, match="my.npz must have 6 actions for hypertuna"):
        policy_header(Policy((np.zeros((4, 2)),), (np.zeros(4),)), ROBOT, "my.npz")
    with pytest.raises(InputError, match="at most 128 neurons"):
        policy_header(Policy((np.zeros((200, 2)), np.zeros((6, 200))), (np.zeros(200), np.zeros(6))), ROBOT, "my.npz")


def test_the_command_names_a_file_that_is_none(tmp_path: Path) -> None:
    out = tmp_path / "policy.hpp"
    made = CliRunner().invoke(app, ["rl", "export", str(tmp_path / "none.npz"), "--robot", "hypertuna", "-o", str(out)])
    assert made.exit_code == 2 or isinstance(made.exception, InputError)
    assert not out.exists()
