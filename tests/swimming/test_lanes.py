"""How gaits are shared out to lanes, threads and instruction sets changes nothing."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hypertuna as ht
from hypertuna import _core
from hypertuna.swimming.gait import Gaits
from models import MODELS, fastest, turning

LANES = 1e-12  # scalar against lanes: only the order of some sums and fused products differ
COUNT = 13  # gaits: no multiple of any number of lanes


def some_gaits(robot: ht.Robot, count: int = COUNT) -> list[ht.Gait]:
    """Gaits between a tenth and all of the fastest one's amplitude, every third of them turning."""
    whole = [turning(robot) if k % 3 == 0 else fastest(robot) for k in range(count)]
    size = np.linspace(0.1, 1.0, count)
    return [
        ht.Gait(gait.frequency * part, tuple(part * a for a in gait.amplitude), gait.phase, gait.bias)
        for gait, part in zip(whole, size.tolist(), strict=True)
    ]


def same(a: xr.Dataset, b: xr.Dataset) -> None:
    """Every bit of the results."""
    for name in a.data_vars:
        np.testing.assert_array_equal(a[name].values, b[name].values, err_msg=str(name))


def test_a_gait_gives_the_same_bits_alone_and_in_any_company(every_model: ht.Robot) -> None:
    gaits = some_gaits(every_model)
    together = ht.sweep(every_model, gaits)
    backward = ht.sweep(every_model, gaits[::-1])
    same(together, backward.isel(gait=slice(None, None, -1)))
    for k, gait in enumerate(gaits):
        same(together.isel(gait=[k]), ht.sweep(every_model, [gait]))
        alone = ht.swim(every_model, gait)
        assert alone.speed == float(together.speed[k])
        assert alone.mechanical_power == float(together.mechanical_power[k])


@pytest.mark.parametrize("method", ["newton", "beats"])
def test_threads_change_nothing(tuna: ht.Robot, method: str) -> None:
    gaits = Gaits.grid(
        frequency=np.linspace(0.5, 6, 12).tolist(),
        amplitude=np.deg2rad([(4.0, 6.0), (8.0, 12.0), (16.0, 25.0)]).tolist(),
        phase=np.deg2rad([(0.0, lag) for lag in range(0, 120, 15)]).tolist(),
    )
    alone = ht.sweep(tuna, gaits, threads=1, method=method, beats=3)  # type: ignore[arg-type]
    for threads in (2, 3, 16):
        same(alone, ht.sweep(tuna, gaits, threads=threads, method=method, beats=3))  # type: ignore[arg-type]


RUN = """
import sys, numpy as np, hypertuna as ht
from models import MODELS
from swimming.test_lanes import results
np.savez(sys.argv[1], isa=ht._core.isa(), **results())
"""


@functools.cache
def results() -> dict[str, np.ndarray]:
    """Speeds, powers and derivatives of all models, as this process computes them."""
    found = {}
    for name, robot in MODELS.items():
        swept = ht.sweep(robot, some_gaits(robot))
        slope = ht.gradient(robot, fastest(robot))
        found |= {
            f"{name} {key}": swept[key].values
            for key in ("speed", "mechanical_power", "tail_excursion", "turn_rate", "status")
        }
        found |= {f"{name} d{key}": getattr(slope, key) for key in ("speed", "cost_of_transport")}
    return found


@pytest.mark.parametrize("isa", [isa for isa in _core.isas() if isa != _core.isa()])
def test_every_other_instruction_set_gives_the_same(isa: str, tmp_path: Path) -> None:
    there = tmp_path / "results.npz"
    path = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"HYPERTUNA_ISA": isa, "PYTHONPATH": path}
    subprocess.run([sys.executable, "-c", RUN, str(there)], env=environment, check=True)
    here = results()
    with np.load(there) as found:
        assert str(found["isa"]) == isa
        for name, expected in here.items():
            np.testing.assert_allclose(found[name], expected, rtol=0, atol=LANES * abs(expected).max(), err_msg=name)


def test_an_instruction_set_that_is_not_there_is_refused() -> None:
    environment = os.environ | {"HYPERTUNA_ISA": "abacus"}
    run = subprocess.run(
        [sys.executable, "-c", "from hypertuna import _core; _core.isa()"],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert run.returncode != 0
    assert "HYPERTUNA_ISA must name an instruction set" in run.stderr
    assert all(isa in run.stderr for isa in _core.isas())
