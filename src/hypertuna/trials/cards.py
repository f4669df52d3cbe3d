"""Cards of trials and of their runs."""

from typing import Any

import numpy as np

from hypertuna.display import Card, Facts, Part, Table, cards, number, tables
from hypertuna.pictures import curve_svg
from hypertuna.swimming.cards import beat_svg
from hypertuna.swimming.gait import gait_table, gait_text
from hypertuna.trials.kind_steady import border, words
from hypertuna.trials.kinds import QUANTITIES, kind_of
from hypertuna.trials.manifest import Recording
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.steady import SteadyRun, measured_columns
from hypertuna.trials.tracks import JointSeries, Track
from hypertuna.trials.trials import Trials


@cards.of(Trials)
def trials_card(trials: Trials) -> Card:
    """Return the card of trials: the number of each kind, and a row with gait and speed for each run."""
    facts = {f"{kind.label}s": f"{len(members)}" for kind, members in trials.kinds.items()}
    rows = [kind_of(trial).cells(trial) for trial in trials.members]
    content: list[Part] = [Facts(facts), Table(("run", "gait", "speed"), rows)]
    return Card(f"Trials: {len(trials.runs)} runs", content, lambda: _trials_svg(trials))


def _trials_svg(trials: Trials) -> str:
    """Return an SVG of the trials of the first kind that has any."""
    return next((kind.picture(members) for kind, members in trials.kinds.items()), "")


@tables.of(Trials)
def trial_columns(trials: Trials) -> dict[str, Any]:
    """Return every run as a row: steady runs with gait and measurements, tracked ones with their duration [s]."""
    import pandas as pd

    parts = [kind.table(members) for kind, members in trials.kinds.items()]
    return dict(pd.concat(parts, ignore_index=True).items())


@tables.of(SteadyRun)
def steady_columns(run: SteadyRun) -> dict[str, Any]:
    """Return a steady run as columns of one row: its gait and measurements, units in the names."""
    columns: dict[str, Any] = {"run": [run.name]} | gait_table([run.gait])
    columns |= {name: [np.nan if value is None else value] for name, value in measured_columns(run).items()}
    return columns | {"repeats": [run.repeats]}


@cards.of(SteadyRun)
def steady_card(run: SteadyRun) -> Card:
    """Return the card of a steady run: its gait, and each measured quantity with its standard deviation."""
    facts = {}
    for name, (key, value, sd) in run.measured().items():
        unit, size = border(QUANTITIES[key])
        facts[words(name)] = number(size * value, unit) + ("" if sd is None else f" ± {number(size * sd)}")
    title = f"Steady run {run.name}: {gait_text(run.gait)}"
    return Card(title, [Facts(facts | {"repeats": f"{run.repeats}"})], lambda: beat_svg(run.gait))


@cards.of(Recording)
def recording_card(recording: Recording) -> Card:
    """Return the card of a recording: samples and ranges of its joint angles, and the number of its runs."""
    series = recording.joints
    facts = _series_facts(series) | {"tracked runs": f"{len(recording.tracks)}"}
    return Card(f"Recording {recording.name}", [Facts(facts)], lambda: _series_svg(series))


@cards.of(JointSeries)
def series_card(series: JointSeries) -> Card:
    """Return the card of measured joint angles: samples, time and ranges."""
    return Card("Measured joint angles", [Facts(_series_facts(series))], lambda: _series_svg(series))


@cards.of(SmoothSeries)
def smooth_card(smoothed: SmoothSeries) -> Card:
    """Return the card of smoothed joint angles: samples, noise and kinds of curves."""
    noise = ", ".join(number(float(level), digits=2) for level in np.degrees(smoothed.noise))
    kinds = ", ".join(dict.fromkeys(type(curve).__name__ for curve in smoothed.curves))
    facts = _series_facts(smoothed.series) | {"noise": f"{noise} deg", "curves": kinds}
    return Card("Smoothed joint angles", [Facts(facts)], lambda: _series_svg(smoothed.series))


@cards.of(Track)
def track_card(track: Track) -> Card:
    """Return the card of a tracked run: its frames, its time and its path."""
    facts = {"frames": f"{len(track.time)}", "time": f"{track.time[0]:g} to {track.time[-1]:g} s"}
    return Card(f"Track {track.run}", [Facts(facts)], lambda: _track_svg(track))


def _track_svg(track: Track) -> str:
    """Return an SVG of the path of a tracked run."""
    x, y = track.pose[:, :2].T
    return curve_svg(x, y, "y [m] over x [m]", equal=True)


def _series_facts(series: JointSeries) -> dict[str, str]:
    """Return samples, time and ranges of joint angles."""
    spans = (
        f"{low:.3g} to {high:.3g}" for low, high in np.degrees([series.angle.min(axis=0), series.angle.max(axis=0)]).T
    )
    return {
        "samples": f"{len(series.time)}",
        "time": f"{series.time[0]:g} to {series.time[-1]:g} s",
        "angles": f"{', '.join(spans)} deg",
    }


def _series_svg(series: JointSeries) -> str:
    """Return an SVG of the angle of the last joint group over time."""
    return curve_svg(series.time, np.degrees(series.angle[:, -1]), "angle of the last joint group [deg] over time [s]")
