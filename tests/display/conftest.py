"""Results of every kind, which the tests of cards and of pictures share."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.sizing import size_pump
from hypertuna.characterization.data import read_bench
from hypertuna.characterization.family import family
from hypertuna.characterization.fit import fit_bench
from hypertuna.characterization.spring import SpringTest, fit_spring
from hypertuna.identification.posterior import posterior
from hypertuna.simulation.posture import posture_test

TANK = Path(__file__).parents[2] / "examples" / "tank"
FEW: dict[str, Any] = {"iterations": 2, "particles": 2}


@pytest.fixture(scope="session")
def made() -> dict[str, Any]:
    """Results of every kind."""
    fish = ht.load("hypertuna")
    gait = ht.named_gait(fish, "optimised-0.3")
    grid = ht.Gaits.grid(frequency=[2.0], amplitude=[(0.2, 0.3)], phase=[(0.0, 0.7)], bias=[(0, 0), (0.2, 0.2)])
    trials = ht.read_trials(TANK / "tank.toml", fish)
    recording = trials.recordings[0]
    mission = ht.read_mission("box")
    flight = ht.fly(mission, fish, duration=5.0)
    fit = ht.identify(fish, TANK / "tank.csv", starts=1)
    return {
        "robot": fish,
        "gaits": grid,
        "swim": ht.swim(fish, gait),
        "rest": ht.swim(fish, gait, from_rest=4.0),
        "gradient": ht.gradient(fish, gait),
        "turning": ht.turn(fish, grid),
        "bend": ht.bend(fish, "I", np.linspace(0, 250e3, 5), unload=True),
        "optimum": ht.optimize(fish, maximize="speed", method="gradient", **FEW),
        "no-optimum": ht.optimize(
            fish, maximize="speed", method="gradient", limits=ht.gait_limits(fish, speed=9.0), **FEW
        ),
        "front": ht.pareto(fish, population=4, generations=1, polish=False),
        "fit": fit,
        "twin": ht.twin(fish, gait, duration=1.0),
        "losses": ht.twin(fish, gait, duration=1.0).losses,
        "dry twin": ht.twin(TANK.parent / "servofish.toml", "cruise", duration=1.0),  # servos alone, no oil
        "dive": ht.dive(fish, gait, duration=4.0),
        "mission": mission,
        "flight": flight,
        "trials": trials,
        "recording": recording,
        "joints": recording.joints,
        "smooth": ht.smooth(recording.joints),
        "track": recording.tracks[0],
        "gait": gait,
        "steady": trials.steady[0],
        "sea": ht.twin_at_sea(fish, gait, duration=4.0),
        "record": flight.record,
        "pump": size_pump(fish, frequency=[1, 2], amplitude=(0.2, 0.3), bore=[3e-3, 4e-3]),
        "posture": posture_test(fish, frequencies=[1.0], angle=(0.1, 0.1), duration=3.0, limits=False),
        "posterior": posterior(fit, 20),
        "scoreboard": ht.score_swimmers(["tunabot"]),
        "bench": fit_bench(fish, read_bench(TANK.parent / "bench" / "bench.csv", fish), "friction", starts=1),
        "next runs": _told_design(),
        "family": family(fish, read_bench(TANK.parent / "bench" / "paper.csv", fish), members=50),
        "spring": fit_spring(SpringTest(np.arange(1.0, 4), np.ones(3, dtype=bool), 0.1 * np.arange(1.0, 4), "a.csv")),
    }


def _told_design() -> ht.NextRuns:
    """Make a run as it is expected, and ask for the next."""
    with ht.TankDesign(None, TANK.parent / "minnow.toml") as tank:
        choice = tank.ask().choices[0]
        tank.tell([ht.SteadyRun(choice.name, choice.run.gait, choice.expected["speed"][0])])
        return tank.ask()
