"""Which coefficients are free by default, and what is assumed of the others: judged on swims that a fit has not seen.

    python validation/identify/defaults.py [FOLDER] [-o defaults.json]       # about two minutes

FOLDER holds the published swims of the robot eel (see validation/rexeel/README.md). Its coefficients are those of
theory (robots/rexeel-theory.toml, normal drag v_n |v_n|). Three splits: fitted on 10 deg and judged on 30 deg, the
reverse, and fitted on the first 2.2 s of both and judged on all 4 s. Errors are over the repeatability of the swims: 1
is best.
"""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.identification import search
from hypertuna.identification.coefficients import free, from_scale, with_values
from hypertuna.identification.experiment import experiment
from hypertuna.identification.names import default_names, default_priors
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import version
from hypertuna.trials.comparison import compare_recording, replay_recording
from hypertuna.trials.importers import import_folder
from hypertuna.trials.manifest import parse_manifest
from hypertuna.trials.trials import Trials

FOLDER = Path(os.environ.get("HYPERTUNA_DATA", Path(__file__).parents[3] / "shared" / "data")) / "rexeel"
EARLY = 2.2  # s, end of the first part of a swim: one second of ramp, then half a beat
# Each one coefficient, common to all links
ALONG, ACROSS, MASS = (f"water.strip.{name}=common" for name in ("drag_tangential", "drag_normal", "added_mass_normal"))
# Added mass of the last link apart from the others'
ENDS = ("water.strip.added_mass_normal[0-4]", "water.strip.added_mass_normal[5]")
SETS: dict[str, tuple[tuple[str, ...], bool]] = {  # which coefficients are free, and whether with default priors
    "none": ((), False),
    "drag along": ((ALONG,), False),
    "drag along, added mass": ((ALONG, MASS), False),
    "both drags, added mass": ((ALONG, ACROSS, MASS), False),
    "the same, with priors": ((ALONG, ACROSS, MASS), True),
    "both drags, added mass of the last link apart": ((ALONG, ACROSS, *ENDS), False),
    "both drags, added mass, shedding": ((ALONG, ACROSS, MASS, "water.strip.tail_shedding"), False),
}


def eel(shedding: float) -> ht.Robot:
    """Return the eel with coefficients from theory, and a fraction of shedding."""
    document = ht.load("rexeel-theory").document()
    document["water"]["strip"] |= {"tail_shedding": shedding, "cross_flow": False}
    return parse(document, file="eel")


def swims(folder: Path, use: str) -> Trials:
    """Return the published swims, with measured joint angles or their targets."""
    document = import_folder(folder)
    for recording in document["recordings"]:
        recording["joints"]["use"] = use
    return Trials(parse_manifest(document, eel(1.0), folder=Path(), file=str(folder)))


def of(trials: Trials, amplitude: str) -> Trials:
    """Return the swims at one amplitude."""
    return trials.only([run for run in trials.runs if run.startswith(amplitude)])


def early(trials: Trials) -> Trials:
    """Return the swims up to `EARLY`."""
    cut = [
        replace(
            recording,
            tracks=tuple(
                replace(track, time=track.time[track.time <= EARLY], pose=track.pose[track.time <= EARLY])
                for track in recording.tracks
            ),
        )
        for recording in trials.recordings
    ]
    return ht.Trials((*trials.steady, *cut))


def fitted(robot: ht.Robot, trials: Trials, names: tuple[str, ...], priors: bool) -> tuple[ht.Robot, list[float]]:
    """Return the robot fitted to trials as by `identify`, from one start, and the fitted values."""
    if not names:
        return robot, []
    frees = free(robot, names, prior=default_priors(robot) if priors else {})
    data = experiment(robot, trials, frees, loss="soft_l1", threads=1)
    with Journal(None, {}) as journal:
        result, _ = search.fit(data, data, search.start_points(frees, 1, 0), journal, None)
    values = from_scale(frees, result["x"])
    return with_values(robot, frees, values), values.tolist()


def judged(robot: ht.Robot, trials: Trials) -> tuple[float, list[list[float]]]:
    """Return the error over the repeatability, and by recording the rmse of x, y [cm] and yaw [deg]."""
    compared = [compare_recording(robot, r, replay_recording(robot, r)) for r in trials.recordings]
    ratio = np.array([c.rmse.to_numpy() / c.repeatability.to_numpy() for c in compared])
    rmse = [(c.rmse.to_numpy() * [100, 100, 180 / np.pi]).tolist() for c in compared]
    return float(np.sqrt(np.mean(ratio**2))), rmse


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_suffix(".json"))
    arguments = parser.parse_args()
    assert default_names(eel(1.0)) == SETS["the same, with priors"][0]
    runs: list[dict[str, Any]] = []
    for use in ("measured", "targets"):
        trials = swims(arguments.folder, use)
        slow, fast = of(trials, "10deg"), of(trials, "30deg")
        splits = {"10 to 30 deg": (slow, fast), "30 to 10 deg": (fast, slow), "early to all": (early(trials), trials)}
        for shedding in (0.0, 1.0):
            for name, (names, priors) in SETS.items():
                row: dict[str, Any] = {"joints": use, "tail_shedding": shedding, "free": name}
                for split, (seen, unseen) in splits.items():
                    robot, values = fitted(eel(shedding), seen, names, priors)
                    ratio, rmse = judged(robot, unseen)
                    row[split] = {"over_repeatability": ratio, "rmse_cm_cm_deg": rmse, "values": values}
                runs.append(row)
                print(use, shedding, name, [round(row[split]["over_repeatability"], 2) for split in splits], flush=True)
    about = {"made_by": "python validation/identify/defaults.py", "hypertuna": version()}
    arguments.output.write_text(json.dumps(about | {"runs": runs}, indent=1) + "\n")


if __name__ == "__main__":
    main()
