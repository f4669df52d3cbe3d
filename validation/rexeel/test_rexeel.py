"""The robot eel's free swims, with coefficients from theory and with fitted ones: README.md beside this file."""

import math
import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.identification.identify import identify
from hypertuna.trials.importers import import_folder
from hypertuna.trials.manifest import parse_manifest
from hypertuna.trials.replay import replay, rmse
from hypertuna.trials.smoothing import smooth
from hypertuna.trials.trials import Trials, read_trials

DATA = Path(os.environ.get("HYPERTUNA_DATA", Path(__file__).parents[3] / "shared" / "data")) / "rexeel"
BORDER = np.array([100, 100, 180 / math.pi])  # from m, m, rad to cm, cm, deg
FRAME = 0.0333  # s, of the videos: how far the clock of the joints may be off
AMPLITUDES = ("10deg", "30deg")

REPEATABILITY = {"10deg": (0.66, 0.66, 0.78), "30deg": (1.20, 0.96, 1.94)}  # as the authors of the data report it
RUNS = {"10deg": 21, "30deg": 20}  # number of recorded swims
THEORY = {"10deg": (0.82, 2.08, 1.56), "30deg": (2.86, 7.16, 4.35)}  # rmse of x [cm], y [cm], yaw [deg]
FITTED = {"10deg": (0.77, 0.69, 1.51), "30deg": (1.97, 1.13, 3.38)}  # rmse after the fit, units as in THEORY
# The same with fitted offsets of the clocks
FITTED_SHIFTED = {"10deg": (0.77, 0.68, 1.00), "30deg": (1.91, 1.16, 2.77)}
MEASURED = {"10deg": (0.76, 0.68, 0.99), "30deg": (1.99, 1.14, 5.08)}  # of the measured angles, clocks as given

# Coefficients that are fitted
FREE = ("water.added_mass_normal[0-4]", "water.added_mass_normal[5]", "water.drag_tangential", "water.drag_normal")
PRIOR = {"water.drag_normal": 1.5}  # about a long flat plate
VALUES = {  # c_a, c_a of the last link, C_t, C_n; fitted on
    "both": (1.613, 0.680, 0.0725, 0.706),
    "10deg": (1.630, 0.565, 0.148, 2.285),
    "30deg": (1.676, 0.609, 0.0673, 0.683),
}
UNSEEN = {"10deg": (0.77, 0.68, 1.01), "30deg": (2.29, 1.23, 2.74)}  # fitted on the other amplitude, clocks shifted

# What a fit comes to without one part of the physics: changes of the strip law, what stays free, rmse at 10 and 30 deg.
WITHOUT = {
    "nothing": ({}, FREE, (0.77, 0.68, 1.00), (1.91, 1.16, 2.77)),
    "drag beyond friction": ({}, (FREE[0], FREE[1], FREE[3]), (0.84, 1.03, 1.32), (1.86, 1.31, 3.29)),
    "mirror and ends": ({}, FREE[2:], (0.77, 0.83, 1.13), (2.18, 1.02, 2.82)),
    "unloaded tail": ({}, ("water.added_mass_normal", *FREE[2:]), (0.75, 0.68, 1.10), (1.91, 1.11, 2.89)),
    "shedding": ({"tail_shedding": 0.0}, FREE, (0.79, 0.75, 1.03), (2.29, 1.25, 2.70)),
    "v_n |v|": ({"cross_flow": False}, FREE, (0.76, 0.69, 1.01), (1.94, 1.09, 2.82)),
    "free drag across": ({}, FREE[:3], (0.77, 0.68, 0.96), (2.26, 1.22, 2.64)),
}

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(),
    reason=f"The eel's measured swims are not at {DATA}: set HYPERTUNA_DATA to the folder that holds rexeel/.",
)


@cache
def swims():
    """Return the swims with commanded angles, up to the walls."""
    return read_trials(DATA, ht.load("rexeel"))


@cache
def whole(amplitude, use="targets"):
    """Return recordings with all frames, those near the walls too, as the authors of the data compare them."""
    document = import_folder(DATA)
    document.pop("tank")
    for recording in document["recordings"]:
        recording["joints"]["use"] = use
    trials = Trials(parse_manifest(document, ht.load("rexeel"), folder=Path(), file="rexeel"))
    return next(recording for recording in trials.recordings if recording.name == amplitude)


def of(amplitude):
    """Return the swims at one amplitude, or all."""
    trials = swims()
    return trials if amplitude == "both" else trials.only([run for run in trials.runs if run.startswith(amplitude)])


def error(robot, recording, offset=0.0, **options):
    """Return the rmse over all frames of all runs: x [cm], y [cm], yaw [deg]."""
    result = replay(robot, smooth(recording.joints), time_offset=offset, **options)
    assert result.status == "completed"
    return rmse(robot, result, recording.tracks).rmse.to_numpy() * BORDER


def theory_of(robot):
    """Return the robot before the fit: coefficients of theory, with the fit's form of the normal drag."""
    plain = {"added_mass_normal": [1.0] * 6, "drag_tangential": [0.0101] * 6, "drag_normal": [1.98] * 6}
    return with_strip(robot, **plain)


def fit(robot, amplitude, free):
    """Fit coefficients and clocks; return the robot, the values and each amplitude's offset of the clock."""
    names = [*free, "time_offset"]
    bounds = {"time_offset": (-FRAME, FRAME), FREE[0]: (0.0, 6.0)}
    bounds = {name: value for name, value in bounds.items() if name in names}
    prior = {name: factor for name, factor in PRIOR.items() if name in free}
    found = identify(robot, of(amplitude), names, bounds=bounds, prior=prior, validate=0, loss="linear", starts=2)
    assert found.converged
    offsets = {f.name[12:-1]: value for f, value in zip(found.free, found.values, strict=True) if "offset" in f.name}
    return found, offsets


def with_strip(robot, **changes):
    """Return the robot with other values in its strip law, not fitted."""
    document = robot.document()
    document.pop("fit", None)
    document["sources"].pop("fit", None)
    document["water"]["strip"] |= changes
    return parse(document, file="changed")


@cache
def fit_of_both():
    """Return the fit to all swims, from theory."""
    return fit(theory_of(ht.load("rexeel")), "both", FREE)


@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_theory(amplitude):
    recording = whole(amplitude)
    theory = ht.load("rexeel-theory")
    assert len(recording.tracks) == RUNS[amplitude]
    compared = rmse(theory, replay(theory, recording.joints), recording.tracks)
    assert compared.rmse.to_numpy() * BORDER == pytest.approx(THEORY[amplitude], rel=0.05)
    assert compared.repeatability.to_numpy() * BORDER == pytest.approx(REPEATABILITY[amplitude], rel=0.02)


@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_fitted_robot(amplitude):
    eel = ht.load("rexeel")
    recording = whole(amplitude)
    plain = error(eel, recording)
    shifted = error(eel, recording, eel.fit.value[eel.fit.names.index(f"time_offset[{amplitude}]")])
    print(f"{amplitude}: head x, y [cm], yaw [deg]: {plain.round(2)}; with the fitted time offset {shifted.round(2)}")
    assert plain == pytest.approx(FITTED[amplitude], rel=0.03)
    assert shifted == pytest.approx(FITTED_SHIFTED[amplitude], rel=0.03)
    # the aim, twice the repeatability: met with the time offset and without
    aim = 2 * np.array(REPEATABILITY[amplitude])
    assert (shifted < aim).all()
    assert (plain < aim).all()


@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_measured_angles_instead_of_the_commanded_ones(amplitude):
    """The servos report late: at 30 deg the yaw is then further off."""
    found = error(ht.load("rexeel"), whole(amplitude, "measured"))
    print(f"{amplitude}, measured angles: {found.round(2)}")
    assert found == pytest.approx(MEASURED[amplitude], rel=0.03)


@pytest.mark.parametrize("amplitude", VALUES)
def test_identified_on_one_amplitude_and_on_both(amplitude):
    found, _ = fit_of_both() if amplitude == "both" else fit(theory_of(ht.load("rexeel")), amplitude, FREE)
    print(f"fitted on {amplitude}: {found.values.round(4)}")
    assert found.values[:4] == pytest.approx(VALUES[amplitude], rel=0.02, abs=0.005)
    shipped = np.array(ht.load("rexeel").fit.value[:4])
    held = (found.uncertainty.low[:4] < shipped) & (shipped < found.uncertainty.high[:4])
    # At 10 deg the drag across is three times as large as at 30 deg: the law has one coefficient for all amplitudes.
    assert held.tolist() == [True, True, True, amplitude != "10deg"]
    for unseen in set(AMPLITUDES) - {amplitude} if amplitude != "both" else ():
        _, offsets = fit(found.robot, unseen, ())
        recording = whole(unseen)
        predicted = error(found.robot, recording, offsets[unseen])
        print(f"{unseen} from {amplitude}: {predicted.round(2)}, offset {offsets[unseen]:.3f} s")
        assert predicted == pytest.approx(UNSEEN[unseen], rel=0.03)


@pytest.mark.parametrize("part", WITHOUT)
def test_each_part_of_the_physics_is_needed(part):
    changes, free, *expected = WITHOUT[part]
    robot = with_strip(theory_of(ht.load("rexeel")), **changes)
    found, offsets = fit_of_both() if part == "nothing" else fit(robot, "both", free)
    errors = [error(found.robot, recording, offsets[recording.name]) for recording in map(whole, AMPLITUDES)]
    print(f"without {part}: {found.values.round(3)}, {np.round(errors, 2).tolist()}")
    for got, known in zip(errors, expected, strict=True):
        assert got == pytest.approx(known, rel=0.03)


def test_scipy_finds_nothing_better():
    """The valley is flat: other values of nearly the same error."""
    eel = ht.load("rexeel")
    recordings = swims().recordings
    runs = [np.sqrt(RUNS[recording.name]) / np.array(REPEATABILITY[recording.name]) for recording in recordings]

    def residual(x):
        strip = {
            "added_mass_normal": [x[0]] * 5 + [x[1]],
            "drag_tangential": [x[2] / 10] * 6,
            "drag_normal": [x[3]] * 6,
        }
        robot = with_strip(eel, **strip)
        offset = dict(zip(AMPLITUDES, x[4:] / 10, strict=True))
        # the rmse of an axis is all that a sum of squares needs
        errors = [error(robot, r, offset[r.name]) * weight for r, weight in zip(recordings, runs, strict=True)]
        return np.concatenate([*errors, [math.log(x[3] / 1.98) / math.log(PRIOR["water.drag_normal"])]])

    limits = ([0, 0, 0, 0.1, -10 * FRAME, -10 * FRAME], [6, 6, 5, 10, 10 * FRAME, 10 * FRAME])
    found = least_squares(residual, [1.5, 1.0, 0.5, 1, 0, 0], bounds=limits, diff_step=1e-4, ftol=1e-4)
    fitted = eel.fit.value
    ours = residual(np.array([*fitted[:2], 10 * fitted[2], fitted[3], *(10 * offset for offset in fitted[4:])]))
    print(f"SciPy: {found.x.round(4)}, cost {found.cost:.5g}; here {ours @ ours / 2:.5g}")
    assert ours @ ours / 2 < 1.005 * found.cost


@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_smoothing_and_step_hardly_matter(amplitude):
    eel = ht.load("rexeel")
    recording = whole(amplitude)
    plain = error(eel, recording)
    assert error(eel, recording, step=0.002) == pytest.approx(plain, rel=1e-3)
    rough = rmse(eel, replay(eel, smooth(recording.joints, noise=0)), recording.tracks).rmse.to_numpy() * BORDER
    assert rough == pytest.approx(plain, rel=5e-3)
