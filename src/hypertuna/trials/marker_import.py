"""Tracked markers into trials: joint angles and head poses of the robot's chain, their files and manifest."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.pose import coordinate_names
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.files import write_atomically
from hypertuna.trials.chain import Chain, ChainFit, chain_of, check_rank, fit_chain, merge, unmerged
from hypertuna.trials.importers import manifest_text
from hypertuna.trials.marker_places import Places, equal_spacing, moved, read_places, straight
from hypertuna.trials.marker_run import Frames, MarkerRun, still_marker
from hypertuna.trials.markers import Markers, read_markers
from hypertuna.trials.plausibility import bend_limits
from hypertuna.trials.tracks import MAX_GAP, MIN_SAMPLES

ROUNDS, SETTLED = 10, 0.1  # of taking places from a run, and noises of the last step
ANOTHER = 30.0  # times the robot's length, or a part of it: markers of another unit
LATE = 100.0  # s, from which on 7 digits are no time
LEARNED = 100  # frames from which places are taken
BESIDE, PAIRS = 0.15, 0.25  # mean spacings between markers at one place; part of all markers that are such pairs
INVERTED = 0.35  # mean spacings by which a marker may lie ahead of the marker before it
MAX_FRAMES = 200  # about the number of frames from which the order is found


@dataclass(frozen=True)
class ChainOptions:
    """Options of the fit to a file's markers: their places, those left out, joints merged, places learned."""

    places: str | Path | None = None  # CSV file of places; without it they are equally spaced from nose to tail
    leave_out: Sequence[str] = ()  # markers without a use
    tail_first: bool = False  # whether equally spaced markers are given from tail to nose
    merge: Sequence[Sequence[str]] = ()  # joint groups that are fitted as one bend
    from_run: bool = False  # whether the places are taken from the run


def read_marker_run(robot: Robot, path: str | Path, *, places: str | Path | None = None, **options: Any) -> MarkerRun:
    """Fit the chain of a robot to the markers of a file; places and options: as of `fit_marker_run`."""
    run = fit_marker_run(robot, path, ChainOptions(places), **options)
    if refusal := run.refusal():
        raise refusal
    return run


def fit_marker_run(robot: Robot, path: str | Path, chain_options: ChainOptions, **options: Any) -> MarkerRun:
    """Fit the chain of a robot to the markers of a file, whether or not the run can be used.

    options: of `read_markers`.
    """
    return fit_markers(robot, read_markers(path, **options), chain_options)


def fit_markers(robot: Robot, markers: Markers, chain_options: ChainOptions) -> MarkerRun:
    """Return the fit of a robot's chain to markers, even if the run cannot be used."""
    markers = _without(markers, chain_options.leave_out)
    where, notes = _places(robot, markers, chain_options)
    tracked = [markers.names.index(name) for name in where.names]
    used = replace(
        markers,
        place=markers.place[:, tracked],
        weight=markers.weight[:, tracked],
        names=where.names,
        notes=(*markers.notes, *notes),
    )
    if not ((used.weight > 0).sum(axis=1) > 1).any():
        fix = "check --min-likelihood, and whether the column of likelihoods counts the other way round"
        raise InputError("must hold frames in which two markers were seen", file=markers.file, fix=fix)
    groups = coordinate_names(robot)
    for name in (name for joint in chain_options.merge for name in joint if name not in groups):
        fix = did_you_mean(name, groups)
        raise InputError("must be a joint group", key="--merge", value=shown(name), fix=fix)

    def fitted(where: Places, markers: Markers) -> tuple[Chain, ChainFit]:
        chain = chain_of(robot, where.link, where.along, where.across)
        sizes = [*(len(group.links) for group in robot.joints), *(1 for _ in robot.hinges)]
        merged, share = merge(chain, chain_options.merge, sizes)
        check_rank(merged, where.names, markers.file)
        _check_size(robot, markers)
        return chain, unmerged(fit_chain(merged, markers.place, markers.weight), share)

    if chain_options.from_run:
        where = _learned(robot, where, used, fitted)
    chain, fit = fitted(where, used)
    stretches = stretches_of(used.time, np.flatnonzero(fit.determined))
    return MarkerRun(Path(markers.file).stem, used, where, chain, fit, stretches, bend_limits(robot))


def _check_size(robot: Robot, markers: Markers) -> None:
    """Check that the markers span about the robot's length: the fit alone does not show a wrong unit."""
    seen = (markers.weight > 0).sum(axis=1)
    fullest = markers.place[seen == seen.max()]
    low, high = np.nanmin(fullest, axis=1), np.nanmax(fullest, axis=1)
    span, length = float(np.median(np.linalg.norm(high - low, axis=1))), robot.body.length
    if not length / ANOTHER < span < ANOTHER * length:
        value, fix = f"{span:.3g} m wide", f"is the unit another one, or the scale? The robot is {length:.3g} m long"
        raise InputError("must span about the robot", file=markers.file, key="the markers", value=value, fix=fix)


def _without(markers: Markers, names: Sequence[str]) -> Markers:
    """Return markers without those of some names."""
    for name in names:
        if name not in markers.names:
            fix = did_you_mean(name, markers.names)
            rule, key = "must be a tracked marker", "--leave-out"
            raise InputError(rule, file=markers.file, key=key, value=shown(name), fix=fix)
    others = [m for m, name in enumerate(markers.names) if name not in names]
    kept_names = tuple(markers.names[m] for m in others)
    return replace(markers, place=markers.place[:, others], weight=markers.weight[:, others], names=kept_names)


def _places(robot: Robot, markers: Markers, chain_options: ChainOptions) -> tuple[Places, tuple[str, ...]]:
    """Return the markers' places on the robot, of a file or equally spaced, and sentences on their order."""
    if chain_options.places is not None:
        return read_places(chain_options.places, robot, markers.names), ()
    order, notes = in_order(markers, pairs=chain_options.from_run)
    names = [markers.names[m] for m in order]
    return equal_spacing(robot, names[::-1] if chain_options.tail_first else names), notes


def _learned(robot: Robot, where: Places, markers: Markers, fitted: Any) -> Places:
    """Return places moved by the markers' mean offsets from them, so that the joint angles' mean is a straight body."""
    every = slice(None, None, len(markers.time) // LEARNED + 1)
    markers = replace(markers, time=markers.time[every], place=markers.place[every], weight=markers.weight[every])
    for _ in range(ROUNDS):
        chain, fit = fitted(where, markers)
        run = MarkerRun("", markers, where, chain, fit, ())
        step = np.nan_to_num(run.offsets)
        previous, where = where, moved(where, step)
        angle = np.mean(fit.angle, axis=0)
        where = straight(robot, chain_of(robot, where.link, where.along, where.across), where, angle)
        shift = np.array([where.along, where.across]) - np.array([previous.along, previous.across])
        if np.abs(shift).max() < SETTLED * max(fit.noise, 1e-6):
            break
    return where


def in_order(markers: Markers, *, pairs: bool = False) -> tuple[list[int], tuple[str, ...]]:
    """Return the indices of markers from nose to tail, and a note if that is not the order of the file.

    Names sorted as text (p1, p10, p2) are put in the order of their numbers. Raise an error if the markers do not lie
    along the body in the order found, or, without `pairs`, many at the place of another.
    """
    names = markers.names
    by_number = sorted(range(len(names)), key=lambda m: _by_numbers(names[m]))
    order = list(range(len(names)))
    notes: tuple[str, ...] = ()
    if by_number != order and list(names) == sorted(names) and _differ_by_number(names):
        order = by_number
        notes = (f"markers are taken in the order of their numbers, {names[order[0]]} to {names[order[-1]]}",)
    _check_order(markers, order, pairs)
    return order, notes


def _by_numbers(name: str) -> list[tuple[bool, int, str]]:
    """Return a sort key for a name, made of its words and numbers, so that m2 comes before m10."""
    parts = re.findall(r"[0-9]{1,12}|[^0-9]+", name.lower())
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts]


def _differ_by_number(names: Sequence[str]) -> bool:
    """Return whether names differ only in their numbers."""
    return len({re.sub("[0-9]+", "0", name) for name in names}) == 1


def _check_order(markers: Markers, order: Sequence[int], pairs: bool) -> None:
    """Check, by the distances between markers, that they lie along the body in the given order."""
    place = markers.place[:: len(markers.time) // MAX_FRAMES + 1][:, list(order)]
    if len(order) < 3 or not np.isfinite(place).all(axis=2).any(axis=0).all():
        return
    positions = _along(place)
    if positions is None:
        return
    positions = positions * np.sign(np.polyfit(np.arange(len(positions)), positions, 1)[0] or 1.0)
    spacing = float(np.ptp(positions)) / (len(positions) - 1)
    if (np.diff(positions) >= -INVERTED * spacing).all():
        beside = np.flatnonzero(np.abs(np.diff(positions)) < BESIDE * spacing)
        if len(beside) > PAIRS * len(positions) and not pairs:
            first, second = (markers.names[order[beside[0] + k]] for k in (0, 1))
            rule, value = (
                "must lie one behind another",
                f"in pairs at one place of the body, as {first} and {second}",
            )
            fix = "raw and smoothed, or left and right? Give --places-from-run FILE, --places, or --leave-out for each"
            raise InputError(rule, file=markers.file, key="the markers", value=value, fix=fix)
        return
    if still := still_marker(markers):
        raise still
    by_distance = [markers.names[order[m]] for m in np.argsort(positions)]
    if by_distance.index(markers.names[order[0]]) > len(by_distance) / 2:
        by_distance.reverse()
    text = ", ".join(by_distance if len(by_distance) <= 12 else [*by_distance[:10], "...", by_distance[-1]])
    rule = f"must lie along the body in the order of the file, but lie as {text}, or the other way round"
    fix = "write them from nose to tail, or give their places with --places, or --leave-out what is no marker; animals "
    fix += "side by side are no body"
    raise InputError(rule, file=markers.file, key="the markers", fix=fix)


def _along(place: Array) -> Array | None:
    """Return positions (markers,) along the body that fit the median distances between markers (frames, markers, 2)."""
    count = place.shape[1]
    distances = np.zeros((count, count))
    for m in range(count):
        distance = np.linalg.norm(place - place[:, m : m + 1], axis=2)
        if not np.isfinite(distance).any(axis=0).all():
            return None  # two markers are never seen in the same frame
        distances[m] = np.nanmedian(distance, axis=0)
    center = np.eye(count) - 1 / count
    value, vector = np.linalg.eigh(-0.5 * center @ (distances + distances.T) ** 2 / 4 @ center)
    along: Array = vector[:, -1] * np.sqrt(max(value[-1], 0.0))
    return along


def write_marker_runs(
    runs: Sequence[MarkerRun],
    robot: Robot,
    output: str | Path,
    comment: str,
    noises: Sequence[tuple[Array, float] | None] = (),
) -> list[str]:
    """Write joint angles and head poses of runs, and a manifest of them; return the names of the files.

    noises: of each run, where they are known: standard deviations (groups,) [rad] of the angles and their memory [s].
    """
    folder, files, recordings = Path(output).parent, [], []
    for run, noise in zip_longest(runs, noises):
        for k, frames in enumerate(run.stretches):
            name = run.name if len(run.stretches) == 1 else f"{run.name}-{k + 1}"
            time, angle, sd = run.markers.time[frames], run.fit.angle[frames], run.fit.sd[frames, 3:]
            data = (time, angle, sd, run.head[frames], run.head_sd[frames])
            entry, written = write_recording(folder, name, run.chain.groups, *data, comment=comment)
            if noise is not None:
                entry["joints"]["noise_deg"] = [float(f"{sd:.4g}") for sd in np.degrees(noise[0])]
                entry["joints"]["noise_tau_s"] = float(f"{noise[1]:.4g}")
            recordings.append(entry)
            files += written
    document = {"format": 1, "robot": robot.name, "recordings": recordings}
    write_atomically(output, manifest_text(document, comment).encode())
    return [*files, str(output)]


def write_recording(
    folder: Path,
    name: str,
    names: Sequence[str],
    time: Array,
    angle: Array,
    angle_sd: Array,
    head: Array,
    head_sd: Array,
    *,
    comment: str,
) -> tuple[dict[str, Any], list[str]]:
    """Write joint angles (frames, groups) [rad] and head poses (frames, 3) [m, m, rad] with their standard deviations.

    Returns the entry of the run in a manifest, and the names of the two files.
    """
    joints, poses = folder / f"{name}-joints.csv", folder / f"{name}-poses.csv"
    groups = [f"joint_{group}" for group in names]
    column_names = ["time_s", *(f"{group}_deg" for group in groups), *(f"{group}_sd_deg" for group in groups)]
    _write(joints, comment, column_names, np.column_stack([time, np.degrees(angle), np.degrees(angle_sd)]))
    turn = np.array([1, 1, 180 / math.pi])
    column_names = ["time_s", "x_m", "y_m", "yaw_deg", "x_sd_m", "y_sd_m", "yaw_sd_deg"]
    _write(poses, comment, column_names, np.column_stack([time, head * turn, head_sd * turn]))
    return _recording(name, groups, joints.name, poses.name), [str(joints), str(poses)]


def _recording(name: str, groups: Sequence[str], joints: str, poses: str) -> dict[str, Any]:
    """Return the manifest's entry of a run, from the names of its groups and files."""
    return {
        "name": name,
        "joints": {"file": joints, "columns": [f"{group}_deg" for group in groups], "unit": "deg"},
        "poses": {
            "files": [poses],
            "x": "x_m",
            "y": "y_m",
            "yaw": "yaw_deg",
            "length_unit": "m",
            "angle_unit": "deg",
        },
        "align": "all",
    }


def _write(path: Path, comment: str, heads: Sequence[str], rows: Array) -> None:
    """Write a CSV file of a comment, a line of names and rows of numbers."""
    lines = [f"# {comment}", ",".join(heads)]
    for time, *row in rows.tolist():
        lines.append(",".join([f"{time:.7g}" if time < LATE else f"{time:.6f}", *(f"{x:.7g}" for x in row)]))
    write_atomically(path, ("\n".join(lines) + "\n").encode())


def stretches_of(time: Array, frames: Frames) -> tuple[Frames, ...]:
    """Return indices of frames split at gaps that a joint series may not have, without short parts; time [s]."""
    if len(frames) < MIN_SAMPLES:
        return ()
    interval = np.diff(time[frames])
    parts = np.split(frames, np.flatnonzero(interval > MAX_GAP * float(np.median(interval))) + 1)
    return tuple(part for part in parts if len(part) >= MIN_SAMPLES)
