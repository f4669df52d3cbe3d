"""The fit of a robot's chain to the markers of a run: poses, angles, residuals of each marker, and warnings."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.swimming.yielding import bend_name
from hypertuna.trials.chain import MAX_SD, Chain, ChainFit
from hypertuna.trials.head_motion import (
    OFTEN,
    filled_of,
    follows,
    jump_sentences,
    jumps_of,
    raised_of,
    repeats_of,
    still_of,
    tail_first,
)
from hypertuna.trials.marker_places import Places
from hypertuna.trials.markers import Markers
from hypertuna.trials.plausibility import BEYOND
from hypertuna.trials.smoothing import strongest_frequency
from hypertuna.trials.tracks import MIN_SAMPLES

Frames = NDArray[np.intp]

LENGTH_TOLERANCE = 0.03  # relative: the line through the markers longer or shorter than the chain's by more
OFFSET_NOISES = 1.0  # mean residual of a marker over the noise, beyond which its place is in doubt
WORST = 3  # markers that are named
MANY = 0.25  # of the markers rejected: the chain may not be that of these markers


@dataclass(frozen=True)
class MarkerRun:
    """The fit of a robot's chain to the markers of a file."""

    name: str
    markers: Markers  # those with a place, in the order of `places`
    places: Places
    chain: Chain
    fit: ChainFit
    stretches: tuple[Frames, ...]  # determined frames without long gaps
    limits: Array = field(default_factory=lambda: np.zeros(0))  # (groups,) [rad] largest angle as described, or NaN

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
        jacobian = np.tile(np.eye(3), (len(heading), 1, 1))
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -half * np.sin(heading), half * np.cos(heading)
        return np.asarray(np.sqrt(np.einsum("fia,fab,fib->fi", jacobian, self.fit.covariance[:, :3, :3], jacobian)))

    def joints(self, frames: Frames) -> Array:
        """Return nose, joints and tail (frames, links + 1, 2) [m]."""
        pose, angle = self.fit.pose[frames], self.fit.angle[frames]
        heading = pose[:, 2:3] + angle @ self.chain.share.T
        steps = self.chain.length[:, np.newaxis] * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        begin = np.zeros_like(steps[:, :1])
        return np.asarray(pose[:, np.newaxis, :2] + np.concatenate([begin, np.cumsum(steps, axis=1)], axis=1))

    @cached_property
    def length_ratio(self) -> float:
        """Median length of the line through the markers over that through their places on the chain.

        Noise and places off the midline lengthen the line, and a chain that is too long for it buckles: of the lengths
        that the straight chain and the fitted one say, the ratio is the nearer to 1, and 1 if these do not agree.
        """
        order = np.argsort(self.chain.along.sum(axis=1), kind="stable")
        given = np.diff(self.markers.place[:, order], axis=1)
        computed = given + np.diff(self.fit.residual[:, order], axis=1)
        straight = np.linalg.norm(
            np.diff(self.chain(np.zeros((1, self.fit.covariance.shape[1])))[0][:, order], axis=1), axis=2
        )
        size = np.linalg.norm(computed, axis=2)
        projected = np.divide((given * computed).sum(axis=2), size, out=np.full(size.shape, np.nan), where=size > 0)
        ratios = []
        for length, base in ((projected, size), (np.linalg.norm(given, axis=2), np.broadcast_to(straight, size.shape))):
            frames = np.isfinite(length).any(axis=1)
            base = np.where(np.isfinite(length), base, 0.0)[frames].sum(axis=1)
            if not frames.any() or not (base > 0).all():
                return math.nan
            ratios.append(float(np.median(np.nansum(length[frames], axis=1) / base)))
        low, high = min(ratios), max(ratios)
        return low if low > 1 else high if high < 1 else 1.0

    @cached_property
    def offsets(self) -> Array:
        """Median distance (markers, 2) [m] of each marker from its place, along and to starboard of its link."""
        return np.asarray(_median(self._in_links()))

    @cached_property
    def noises(self) -> Array:
        """Standard deviation (markers,) [m] of a coordinate of each marker about its mean place, outliers apart."""
        distance = np.linalg.norm(self._in_links() - self.offsets, axis=2)
        return np.asarray(_median(distance) / 1.1774)  # the median of Rayleigh's distribution

    def _in_links(self) -> Array:
        """Return the offsets (frames, markers, 2) [m] of markers from their places, along and to starboard of links."""
        angle = self.fit.pose[:, 2:3] + self.fit.angle @ self.chain.share.T
        heading = angle[:, list(self.places.link)]
        x, y = -self.fit.residual[..., 0], -self.fit.residual[..., 1]
        return np.stack([np.cos(heading) * x + np.sin(heading) * y, np.cos(heading) * y - np.sin(heading) * x], axis=-1)

    def record(self) -> dict[str, Any]:
        """Return the results of the fit as JSON has them, units in the names."""
        fit, seen, frames = self.fit, self.markers.weight > 0, self.fit.determined
        sd = np.median(fit.sd[frames], axis=0)
        head = np.median(self.head_sd[frames], axis=0)
        rms = np.sqrt(_mean(np.where(fit.rejected[..., np.newaxis], np.nan, fit.residual) ** 2).mean(axis=1))
        return {
            "name": self.name,
            "file": self.markers.file,
            "form": self.markers.form,
            "frames": len(seen),
            "frames_used": int(sum(map(len, self.stretches))),
            "recordings": len(self.stretches),
            "markers": list(self.places.names),
            "missing": int((~seen).sum()),
            "rejected": int(fit.rejected.sum()),
            "noise_mm": 1e3 * fit.noise,
            "marker_rms_mm": 1e3 * rms,
            "marker_missing": (~seen).sum(axis=0),
            "marker_rejected": fit.rejected.sum(axis=0),
            "marker_noise_mm": 1e3 * self.noises,
            "marker_along_mm": 1e3 * self.offsets[:, 0],
            "marker_across_mm": 1e3 * self.offsets[:, 1],
            "length_ratio": self.length_ratio,
            "angle_sd_deg": np.degrees(sd[3:]),
            "head_sd_mm": 1e3 * head[:2],
            "yaw_sd_deg": float(np.degrees(head[2])),
            "warnings": self.warnings,
        }

    def bends(self, robot: Robot) -> dict[str, Any]:
        """Return the beat of each hinge, as columns of steady runs have it, over the longest stretch: {} without any.

        The lag is behind the first joint group, whose phase is 0.
        """
        if not (robot.hinges and self.stretches):
            return {}
        frames, groups = max(self.stretches, key=len), len(robot.joints)
        time, angle = self.markers.time[frames], self.fit.angle[frames]
        frequency = strongest_frequency(time, angle[:, :groups])
        clock = 2 * math.pi * frequency * time
        waves = np.column_stack([np.ones(len(time)), np.sin(clock), np.cos(clock)])
        _, sine, cosine = np.linalg.lstsq(waves, angle)[0]
        swing, lag = np.degrees(np.hypot(sine, cosine)), np.degrees(np.arctan2(-cosine, sine))
        found: dict[str, Any] = {"frequency_hz": frequency}
        for d in range(len(robot.hinges)):
            behind = float((lag[groups + d] - lag[0]) % 360)
            values = {"bend_amplitude": float(swing[groups + d]), "bend_lag": behind}
            found |= {f"{bend_name(robot.hinges, name, d)}_deg": value for name, value in values.items()}
        return found

    @property
    def warnings(self) -> list[str]:
        """Sentences that advise the user on doubtful results."""
        sentences = [*self.markers.notes, *self.contradictions]
        if self.markers.ignored:
            sentences.append(f"columns without a use: {', '.join(self.markers.ignored)}")
        if unused := len(self.markers.time) - sum(map(len, self.stretches)):
            frames = "1 frame is" if unused == 1 else f"{unused} frames are"
            sentences.append(f"{frames} left out, in which the markers leave an angle open")
        return [f"{self.name}: {sentence}{'.' * (not sentence.endswith('?'))}" for sentence in sentences]

    @property
    def contradictions(self) -> list[str]:
        """Sentences on results that contradict the robot's description."""
        sentences = []
        distance = np.linalg.norm(self.offsets, axis=1)
        doubtful = np.argsort(-distance)[: np.count_nonzero(distance > OFFSET_NOISES * self.fit.noise)].tolist()
        if abs(self.length_ratio - 1) > LENGTH_TOLERANCE:
            doubtful = []  # which a wrong scale makes of right places
            sentences.append(f"{_longer(self.length_ratio)} than along the chain: {_scale_fix(self.length_ratio)}")
        seen = int((self.markers.weight > 0).sum())
        if self.fit.rejected.sum() >= MANY * seen:
            share = f"{100 * self.fit.rejected.sum() / seen:.0f} % of the markers are rejected"
            sentences.append(f"{share}: check their order, their places and the robot before you use the angles")
        for m in doubtful[:WORST]:
            sentences.append(f"marker {self.places.names[m]} {self._lies(m)}: check its place, {self._place_fix(m)}")
        if len(doubtful) > WORST:
            others = f"{len(doubtful) - WORST} more markers lie off their places"
            sentences.append(f"{others}: see the table, or take all places from the run by --places-from-run FILE")
        largest = np.max(np.abs(self.fit.angle[np.concatenate(self.stretches)]), axis=0) if self.stretches else []
        for group, angle, limit in zip(self.chain.groups, largest, self.limits, strict=False):
            if angle > BEYOND * limit:
                bends = f"joint {group} bends by {math.degrees(angle):.0f} deg, and is described for"
                sentences.append(f"{bends} {math.degrees(limit):.0f} deg: check the order of the markers and the robot")
        sentences += jump_sentences(self.markers.time, *self._jumps)
        sentences += _made_frames(self.markers.place)
        if (still := still_of(self.markers.place)) is not None or follows(self.markers.place):
            what = "the mean of the markers" if still is None else f"marker {self.places.names[still]}"
            sentences.append(f"{what} stands still while others move: are the places from it, or is the fish held?")
        if tail_first(self.head, self.stretches, float(self.chain.length.sum())):
            text = "the robot moves tail first all the time: if it does not, the markers are given from tail to nose"
            sentences.append(f"{text}; give them from nose to tail, or --tail-first")
        return sentences

    def _lies(self, m: int) -> str:
        """Return a text of a marker's offset [mm] from its place."""
        x, y = 1e3 * self.offsets[m]
        return f"lies {x:+.1f} mm along and {y:+.1f} mm across its link from its place, in the mean of all frames"

    def _place_fix(self, m: int) -> str:
        """Return a text of the place, link and [m], that a marker should be given."""
        along, across = self.offsets[m] + (self.places.along[m], self.places.across[m])
        return f"along_m = {along:.4f} and across_m = {across:.4f} on link {self.places.link[m]} would fit"

    @cached_property
    def _jumps(self) -> tuple[Frames, Frames]:
        """Frames before which the head flips, and those before which it leaps away."""
        return jumps_of(self.markers.time, self.head, self.stretches, float(self.chain.length.sum()))

    def refusal(self) -> InputError | None:
        """Return the error to raise if no part of the run can be used, with its cause and advice; otherwise None.

        A chain that is too long for the line through the markers buckles: its angles are wrong in every frame.
        """
        if self.stretches and self.length_ratio < 1 - LENGTH_TOLERANCE:
            rule = (
                f"must be as long as along the chain, within {100 * LENGTH_TOLERANCE:g} %, for a longer chain buckles"
            )
            value, fix = f"{100 * (1 - self.length_ratio):.0f} % shorter", _scale_fix(self.length_ratio)
            return InputError(rule, file=self.markers.file, key="the line through the markers", value=value, fix=fix)
        steps = sum(len(frames) - 1 for frames in self.stretches)
        if steps and (jumps := sum(map(len, self._jumps))) > OFTEN * steps:
            rule, value = "must go on from frame to frame", f"flipping or leaping away in {jumps} of {steps} steps"
            fix = "the labels change ends, or animals are mixed up: mend the track, or choose one animal"
            return InputError(rule, file=self.markers.file, key="the head", value=value, fix=fix)
        if self.stretches:
            return None
        fit, names, file = self.fit, self.places.names, self.markers.file
        rule = f"must determine every angle in {MIN_SAMPLES} consecutive frames"
        if still := still_marker(self.markers):
            return still
        seen = self.markers.weight > 0
        needed = 1 + fit.covariance.shape[1] // 2
        full, settled = seen.sum(axis=1) >= needed, int(fit.determined.sum())
        if abs(self.length_ratio - 1) > LENGTH_TOLERANCE and full.sum() >= MIN_SAMPLES:
            longer = _longer(self.length_ratio)
            fix = f"correct the scale: {longer} than along the body; {_scale_fix(self.length_ratio)}"
            return InputError(rule, file=file, value=f"{settled} frames", fix=fix)
        if full.sum() < MIN_SAMPLES:
            rarest = names[int(np.argmin(seen.sum(axis=0)))]
            value = f"{int(full.sum())} of {len(seen)} in which {needed} markers are seen"
            fix = f"track more markers, lower --min-likelihood, or --merge joints; {rarest} is seen least"
            return InputError(rule, file=file, value=value, fix=fix)
        if settled >= MIN_SAMPLES:
            value = f"{settled} frames with gaps between them, the longest stretch of {self._longest()}"
            return InputError(rule, file=file, value=value, fix="track the lost frames, or --merge joints")
        sds = np.degrees(np.median(fit.sd[full][:, 3:], axis=0))
        joint, worst = int(np.argmax(sds)), int(np.nanargmax(np.linalg.norm(self.offsets, axis=1)))
        value = f"{settled} frames: with markers {1e3 * fit.noise:.2g} mm off the chain, joint "
        size = f"{sds[joint]:.0f}" if sds[joint] < 90 else "more than 90"
        value += f"{self.chain.groups[joint]} is uncertain by {size} deg, beyond {math.degrees(MAX_SD):.0f}"
        if np.linalg.norm(self.offsets[worst]) > OFFSET_NOISES * float(np.nanmedian(self.noises)):
            name = names[worst]
            fix = f"marker {name} {self._lies(worst)}: {self._place_fix(worst)} in --places; or take all places from "
            fix += f"the run by --places-from-run FILE, or --leave-out {name}"
        else:
            missing = f"{100 * (1 - seen.mean()):.0f} % of the markers are missing: " if seen.mean() < 1 - MANY else ""
            fix = f"{missing}add markers near that joint, or --merge it with its neighbor"
        return InputError(rule, file=file, value=value, fix=fix)

    def _longest(self) -> int:
        """Return the largest number of determined frames in a row."""
        ends = np.flatnonzero(np.diff(np.concatenate([[0], self.fit.determined.astype(int), [0]])))
        return int((ends[1::2] - ends[::2]).max()) if len(ends) else 0


def _made_frames(place: Array) -> list[str]:
    """Return sentences on frames of markers (frames, markers, 2) that no camera saw."""
    factor, interpolated = raised_of(place)
    if factor > 1:
        what = "frames lie midway between others" if interpolated else "frames repeat the one before"
        text = f"{what}, as if the frame rate was raised {float(factor):g} times: track the film as the camera wrote it"
        return [f"{text}, or leave these rows out"]
    sentences = []
    if repeated := repeats_of(place):
        frames = "1 frame repeats" if repeated == 1 else f"{repeated} frames repeat"
        fix = "are lost ones filled in, or was the frame rate raised? Leave them empty"
        sentences.append(f"{frames} the one before: {fix}")
    if filled := filled_of(place):
        text = "frames lie on straight lines or cubics between others: are lost ones filled in? Leave them empty"
        sentences.append(f"{filled} {text}")
    return sentences


def still_marker(markers: Markers) -> InputError | None:
    """Return the error of a marker that stands still while the others move, such as a corner of the tank."""
    if (still := still_of(markers.place)) is None:
        return None
    rule, name = "must move with the others, or be left out", markers.names[still]
    fix = f"if it is none of the body, give --leave-out {name}"
    return InputError(rule, file=markers.file, key=f"marker {name}", value="still while the others move", fix=fix)


def _longer(ratio: float) -> str:
    """Return a sentence on how much longer or shorter the line through the markers is, by a ratio."""
    percent = f"{100 * abs(ratio - 1):.0f} % {'longer' if ratio > 1 else 'shorter'}"
    return f"the line through the markers is {percent}"


def _scale_fix(ratio: float) -> str:
    """Return the advice on a line through the markers that is too long or too short by a ratio."""
    places = "the places of the markers, the lengths of the links, and whether the camera looks straight down"
    return f"{1 / ratio:.3g} times the scale would fit; check the scale, {places}"


def _mean(values: Array) -> Array:
    """Return means over frames (frames, markers, ...); NaN for a marker that none of them shows."""
    count = np.isfinite(values).sum(axis=0)
    means: Array = np.divide(np.nansum(values, axis=0), count, out=np.full(count.shape, np.nan), where=count > 0)
    return means


def _median(values: Array) -> Array:
    """Return medians over frames; NaN for a marker that none of them shows."""
    shown = np.isfinite(values).any(axis=0)
    medians: Array = np.nanmedian(np.where(shown, values, 0.0), axis=0)
    return np.where(shown, medians, np.nan)
