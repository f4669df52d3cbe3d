"""Tracked markers into trials: joint angles and head poses of the robot's chain, their files and manifest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.files import write_atomically
from hypertuna.trials.chain import Chain, ChainFit, chain_of, check_rank, fit_chain
from hypertuna.trials.importers import manifest_text
from hypertuna.trials.marker_places import Places, equal_spacing, read_places
from hypertuna.trials.markers import Markers, read_markers
from hypertuna.trials.tracks import MAX_GAP, MIN_SAMPLES

Frames = NDArray[np.intp]

LENGTH_TOLERANCE = 0.03  # relative: the line through the markers longer or shorter than the chain's by more
OFFSET_NOISES = 1.0  # mean residual of a marker over the noise, beyond which its place is in doubt


@dataclass(frozen=True)
class MarkerRun:
    """The chain of a robot over the markers of a file."""

    name: str
    markers: Markers  # those with a place, in the order of `places`
    places: Places
    chain: Chain
    fit: ChainFit
    stretches: tuple[Frames, ...]  # determined frames without long gaps

    @property
    def head(self) -> Array:
        """Poses (frames, 3) of the center of the head link: x, y [m] and the direction faced [rad]."""
        x, y, heading = self.fit.pose.T
        half = self.chain.length[0] / 2
        return np.column_stack([x + half * np.cos(heading), y + half * np.sin(heading), heading + math.pi])

    @property
    def head_sd(self) -> Array:
        """Standard deviations (frames, 3) of the head poses [m, m, rad]."""
        heading, half = self.fit.pose[:, 2], self.chain.length[0] / 2
        by = np.tile(np.eye(3), (len(heading), 1, 1))
        by[:, 0, 2], by[:, 1, 2] = -half * np.sin(heading), half * np.cos(heading)
        return np.asarray(np.sqrt(np.einsum("fia,fab,fib->fi", by, self.fit.covariance[:, :3, :3], by)))

    @property
    def length_ratio(self) -> float:
        """Median length of the line through the markers over that through their places on the chain."""
        seen = (self.markers.weight > 0).all(axis=1) & ~self.fit.rejected.any(axis=1)
        order = np.argsort(self.chain.along.sum(axis=1), kind="stable")
        given = self.markers.place[seen][:, order]
        computed = given + self.fit.residual[seen][:, order]
        lengths = [np.linalg.norm(np.diff(line, axis=1), axis=2).sum(axis=1) for line in (given, computed)]
        return float(np.median(lengths[0] / lengths[1])) if seen.any() else math.nan

    def record(self) -> dict[str, Any]:
        """Return what the fit found, units in the names."""
        fit, seen, own = self.fit, self.markers.weight > 0, self.fit.determined
        sd = np.median(fit.sd[own], axis=0)
        head = np.median(self.head_sd[own], axis=0)
        rms = np.sqrt(_mean(np.where(fit.rejected[..., np.newaxis], np.nan, fit.residual) ** 2).mean(axis=1))
        return {
            "name": self.name,
            "file": self.markers.file,
            "frames": len(seen),
            "frames_used": int(sum(map(len, self.stretches))),
            "recordings": len(self.stretches),
            "markers": list(self.places.names),
            "missing": int((~seen).sum()),
            "rejected": int(fit.rejected.sum()),
            "noise_mm": 1e3 * fit.noise,
            "marker_rms_mm": 1e3 * rms,
            "length_ratio": self.length_ratio,
            "angle_sd_deg": np.degrees(sd[3:]),
            "head_sd_mm": 1e3 * head[:2],
            "yaw_sd_deg": float(np.degrees(head[2])),
            "warnings": self.warnings,
        }

    @property
    def warnings(self) -> list[str]:
        """Sentences on what to check."""
        sentences = []
        if abs(self.length_ratio - 1) > LENGTH_TOLERANCE:
            percent = f"{100 * abs(self.length_ratio - 1):.0f} % {'longer' if self.length_ratio > 1 else 'shorter'}"
            sentences.append(
                f"{self.name}: the line through the markers is {percent} than along the chain: check the scale, the "
                "places of the markers and the lengths of the links."
            )
        for name, offset in zip(self.places.names, self._offsets(), strict=True):
            if np.linalg.norm(offset) > OFFSET_NOISES * self.fit.noise:
                x, y = 1e3 * offset
                sentences.append(
                    f"{self.name}: marker {name} lies {x:+.1f} mm along and {y:+.1f} mm across its link from its "
                    "place, in the mean of all frames: check its place."
                )
        if self.markers.ignored:
            sentences.append(f"{self.name}: columns without a use: {', '.join(self.markers.ignored)}.")
        if lost := len(self.markers.time) - sum(map(len, self.stretches)):
            frames = "1 frame is" if lost == 1 else f"{lost} frames are"
            sentences.append(f"{self.name}: {frames} left out, in which the markers leave an angle open.")
        return sentences

    def _offsets(self) -> Array:
        """Return the mean residual (markers, 2) [m] of each marker along and across its link."""
        angle = self.fit.pose[:, 2:3] + self.fit.angle @ self.chain.share.T
        own = angle[:, list(self.places.link)]
        residual = -np.where(self.fit.rejected[..., np.newaxis], np.nan, self.fit.residual)
        x, y = residual[..., 0], residual[..., 1]
        along, across = np.cos(own) * x + np.sin(own) * y, np.cos(own) * y - np.sin(own) * x
        keep = self.fit.determined
        return np.column_stack([_mean(along[keep]), _mean(across[keep])])


def _mean(values: Array) -> Array:
    """Return means over frames (frames, markers, ...); NaN for a marker that none of them shows."""
    count = np.isfinite(values).sum(axis=0)
    means: Array = np.divide(np.nansum(values, axis=0), count, out=np.full(count.shape, np.nan), where=count > 0)
    return means


def read_marker_run(robot: Robot, path: str | Path, *, places: str | Path | None = None, **options: Any) -> MarkerRun:
    """Fit the chain of a robot to the markers of a CSV file.

    places: CSV file of the markers' places; without it they are equally spaced from nose to tail, in their order.
    options: of `read_markers`.
    """
    markers = read_markers(path, **options)
    where = equal_spacing(robot, markers.names) if places is None else read_places(places, robot, markers.names)
    own = [markers.names.index(name) for name in where.names]
    kept = Markers(
        markers.time, markers.place[:, own], markers.weight[:, own], where.names, markers.file, markers.ignored
    )
    if not (kept.weight > 0).any():
        fix = "check the scale and --min-likelihood"
        raise InputError("must hold markers that were seen", file=markers.file, fix=fix)
    chain = chain_of(robot, where.link, where.along, where.across)
    check_rank(chain, where.names, markers.file)
    fit = fit_chain(chain, kept.place, kept.weight)
    stretches = stretches_of(kept.time, np.flatnonzero(fit.determined))
    if not stretches:
        rule = f"must determine every angle in {MIN_SAMPLES} consecutive frames"
        value, fix = f"{int(fit.determined.sum())} frames", "track more markers, or lower --min-likelihood"
        ratio = _straight_ratio(chain, kept)
        if abs(ratio - 1) > LENGTH_TOLERANCE:
            percent = f"{100 * abs(ratio - 1):.0f} % {'longer' if ratio > 1 else 'shorter'}"
            fix = f"correct the scale: the line through the markers is {percent} than along the body"
        raise InputError(rule, file=markers.file, value=value, fix=fix)
    return MarkerRun(Path(path).stem, kept, where, chain, fit, stretches)


def _straight_ratio(chain: Chain, markers: Markers) -> float:
    """Return the median length of the line through the markers over that along the straight body."""
    distance = chain.along.sum(axis=1)
    order = np.argsort(distance, kind="stable")
    lengths = np.linalg.norm(np.diff(markers.place[:, order], axis=1), axis=2).sum(axis=1)
    return float(np.nanmedian(lengths) / np.ptp(distance)) if np.isfinite(lengths).any() else 1.0


def write_marker_runs(runs: Sequence[MarkerRun], robot: Robot, output: str | Path, comment: str) -> list[str]:
    """Write joint angles and head poses of runs, and a manifest of them; return the names of the files."""
    folder, files, recordings = Path(output).parent, [], []
    for run in runs:
        for k, frames in enumerate(run.stretches):
            name = run.name if len(run.stretches) == 1 else f"{run.name}-{k + 1}"
            time, angle, sd = run.markers.time[frames], run.fit.angle[frames], run.fit.sd[frames, 3:]
            own = (time, angle, sd, run.head[frames], run.head_sd[frames])
            entry, written = write_recording(folder, name, run.chain.groups, *own, comment=comment)
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
    heads = ["time_s", *(f"{group}_deg" for group in groups), *(f"{group}_sd_deg" for group in groups)]
    _write(joints, comment, heads, np.column_stack([time, np.degrees(angle), np.degrees(angle_sd)]))
    turn = np.array([1, 1, 180 / math.pi])
    heads = ["time_s", "x_m", "y_m", "yaw_deg", "x_sd_m", "y_sd_m", "yaw_sd_deg"]
    _write(poses, comment, heads, np.column_stack([time, head * turn, head_sd * turn]))
    return _recording(name, groups, joints.name, poses.name), [str(joints), str(poses)]


def _recording(name: str, groups: Sequence[str], joints: str, poses: str) -> dict[str, Any]:
    """Return the entry of a run in a manifest."""
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
    """Write a table of numbers below a comment."""
    lines = [f"# {comment}", ",".join(heads), *(",".join(f"{x:.7g}" for x in row) for row in rows.tolist())]
    write_atomically(path, ("\n".join(lines) + "\n").encode())


def stretches_of(time: Array, frames: Frames) -> tuple[Frames, ...]:
    """Split frames at gaps that a joint series may not have; leave out short parts."""
    if len(frames) < MIN_SAMPLES:
        return ()
    interval = np.diff(time[frames])
    parts = np.split(frames, np.flatnonzero(interval > MAX_GAP * float(np.median(interval))) + 1)
    return tuple(part for part in parts if len(part) >= MIN_SAMPLES)
