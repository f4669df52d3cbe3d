"""A policy on the emulated Cortex-M7: the actions of the network, the gaits that they mean, within the tick."""

import itertools
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import hypertuna as ht
from hypertuna.cli.main import app
from hypertuna.errors import InputError
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
    policy = Policy((rng.normal(size=(3, 13)), rng.normal(size=(6, 3))), (np.zeros(3), np.ones(6)))
    text = policy_header(policy, ROBOT, "my.npz", step=0.1)
    assert "{13, 3, weight_0, bias_0}, {3, 6, weight_1, bias_1}" in text
    assert f"{policy.weights[0][2, 1]:.9g}f" in text
    assert "bias_1[] = {1.0f, 1.0f" in text
    assert "    2, policy_numbers::layers, 10, 2," in text
    assert "    2, policy_numbers::layers, 50, 2," in policy_header(policy, ROBOT, "my.npz", step=0.5)
    with pytest.raises(InputError, match="step must be whole control ticks of 0.01 s"):
        policy_header(policy, ROBOT, "my.npz", step=0.005)
    for sizes, task, message in (
        ((13, 4), None, "my.npz must have 6 actions for hypertuna"),
        ((13, 200, 6), None, "layers of 1 to 128 neurons, but is 13, 200, 6"),
        ((13, 0, 6), None, "layers of 1 to 128 neurons"),
        ((0, 6), None, "layers of 1 to 128 neurons"),
        ((11, 6), None, "at least 12 inputs for hypertuna, but is 11"),
        ((14, 6), "Goto", "15 inputs for Goto with hypertuna, but is 14"),
    ):
        pairs = [(np.zeros((out, into)), np.zeros(out)) for into, out in itertools.pairwise(sizes)]
        with pytest.raises(InputError, match=message):
            policy_header(Policy(*zip(*pairs, strict=True), task=task), ROBOT, "my.npz", step=0.1)
    with pytest.raises(InputError, match="range of single precision"):
        policy_header(Policy((np.full((6, 13), 1e39),), (np.zeros(6),)), ROBOT, "my.npz", step=0.1)


def export(file: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Export a policy for hypertuna to policy.hpp beside it."""
    command = (sys.executable, "-m", "hypertuna", "rl", "export", str(file), "--robot", "hypertuna")
    out = ("-o", str(file.with_name("policy.hpp")))
    return subprocess.run((*command, *out, *options), capture_output=True, text=True, check=False)


@pytest.mark.parametrize("kind", ["none", "array", "truncated", "empty", "scalars"])
def test_the_command_names_a_file_that_is_none(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "bad.npz"
    if kind == "array":
        np.save(tmp_path / "bad.npy", np.zeros((6, 15)))
        (tmp_path / "bad.npy").rename(file)
    elif kind == "truncated":
        file.write_bytes(TRAINED.read_bytes()[:9000])
    elif kind == "empty":
        file.touch()
    elif kind == "scalars":
        np.savez(file, weight0=1.0, bias0=0.0)
    made = export(file)
    assert made.returncode == 2
    assert made.stderr.startswith(f"error: {file}")
    assert "Traceback" not in made.stderr
    assert not (tmp_path / "policy.hpp").exists()


def test_the_step_is_that_of_the_training(tmp_path: Path) -> None:
    file, bare, header = tmp_path / "goto.npz", tmp_path / "bare.npz", tmp_path / "policy.hpp"
    shutil.copy(TRAINED, file)
    np.savez(bare, **{name: part for name, part in np.load(TRAINED).items() if name[-1].isdigit()})
    for path, options in ((file, ("--step", "0.1")), (bare, ()), (bare, ("--step", "0.005")), (bare, ("--step", "-1"))):
        made = export(path, *options)
        assert made.returncode == 2
        assert made.stderr.startswith("error: --step must be"), made.stderr
        assert not header.exists()
    for path, options in ((file, ()), (file, ("--step", "0.5")), (bare, ("--step", "0.5"))):
        made = export(path, *options)
        assert made.returncode == 0, made.stderr
        assert "    3, policy_numbers::layers, 50, 2," in header.read_text()
        header.unlink()
