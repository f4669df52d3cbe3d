"""What the screen shows so that it is understood at once: maps of grids, panels of help, a line on why."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

import hypertuna as ht
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.plots import plot_sweep
from program import Run


def test_a_grid_of_many_frequencies_and_phases_is_a_map(tuna: ht.Robot) -> None:
    def plotted(frequencies: int, phases: int) -> Figure:
        phase = [(0, angle) for angle in np.linspace(0, 80, phases)]
        axes: Any = {"frequency": np.linspace(1, 6, frequencies), "amplitude": [(16, 25)], "phase": phase}
        return plot_sweep(ht.sweep(tuna, Gaits.grid_degrees(**axes)))

    speed, _, bar, _ = plotted(6, 7).axes
    assert not speed.lines
    assert speed.get_ylabel() == "phase of joint II [deg]"
    assert bar.get_ylabel() == "speed [m/s]"
    assert len(plotted(6, 5).axes[0].lines) == 5


def test_a_group_that_is_a_command_has_its_options_in_panels(run: Run) -> None:
    help = run("optimize", "--help")[1]
    places = [help.index(f"{title}:") for title in ("Robot", "Options", "Output", "Commands")]
    assert places == sorted(places)


def test_a_log_without_its_command_is_told_the_command(run: Run) -> None:
    assert run("log", "dive.mcap")[2].endswith("did you mean `hypertuna log info dive.mcap`?\n")


def test_the_twin_of_servo_joints_explains_its_errors(run: Run) -> None:
    output = run("twin", "--robot", "examples/servofish.toml", "--duration", "4")[1]
    assert "No sensor reads the bend of J1 and J2" in " ".join(output.split())
