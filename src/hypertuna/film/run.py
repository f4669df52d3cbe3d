"""Turn a film into a trial: joint angles and head poses with their errors, written as files with a manifest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.film.camera import Camera
from hypertuna.film.noise import Beat, beat_of, path_noise
from hypertuna.film.pace import check_made
from hypertuna.film.sections import COLUMNS, Body, body_of
from hypertuna.film.source import Film, open_film
from hypertuna.film.states import FIXES, OK, STATES
from hypertuna.film.track import MIN_SEEN, Tracked, Tracker, Tuning, check_seen, forward, links_of, track, tune
from hypertuna.film.view import View, view_of
from hypertuna.io.checkpoint import Journal
from hypertuna.io.files import columns_csv, write_atomically
from hypertuna.trials.head_motion import repeats_of
from hypertuna.trials.importers import manifest_text
from hypertuna.trials.marker_import import stretches_of, write_recording
from hypertuna.trials.marker_run import Frames
from hypertuna.trials.tracks import MIN_SAMPLES

MOVES = 0.5  # px by which the tank may move in the picture
STILL = 0.1  # of the usual step: a frame that repeats the one before
MIN_OK = 0.5  # smallest fraction of frames that must be tracked well
MAX_SIZE_ERROR = 0.10  # largest relative difference of the length that the camera sees from the robot's
WARN_SIZE_ERROR = 0.02  # relative difference of length beyond which the user is warned
WARN_GIRTH = 5.0  # percent: difference of width beyond which the user is warned
STATION_STEP = 5  # every fifth station of the body is written to the file of learned widths
BACKWARD = 0.2  # body lengths swum tail first, beyond which the fish is tracked again with its ends swapped
JUMP, JUMP_STEPS = 0.1, 6.0  # a longer step than both is a jump: body lengths; multiples of the median step


@dataclass(frozen=True)
class FilmRun:
    """The fish tracked through a film: joint angles, head poses and their errors."""

    name: str
    view: View
    body: Body
    tuning: Tuning
    tracked: Tracked
    beat: Beat | None
    head_noise: Array  # (3,) [m, m, rad]: standard deviations of the head's pose
    scale: str  # what sets the scale of lengths: "fish" or "camera"
    stretches: tuple[Frames, ...]  # frames in use, without long gaps

    @property
    def size(self) -> float:
        """Ratio of the length that the camera sees to the robot's length [1]."""
        return math.exp(self.tuning.size)

    @property
    def angle(self) -> Array:
        """Joint angles (frames, groups) [rad]."""
        return self.tracked.unknowns[:, 3:]

    @property
    def noise(self) -> Array:
        """Standard deviations (groups,) [rad] of the joint angles: the larger of ripples' and pixels' noise."""
        pixels = np.median(_sd(self.tracked)[self.tracked.state == OK, 3:], axis=0)
        return np.asarray(pixels if self.beat is None else np.maximum(self.beat.noise, pixels))

    @property
    def angle_sd(self) -> Array:
        """Standard deviations of the joint angles (frames, groups) [rad]."""
        return np.asarray(np.maximum(_sd(self.tracked)[:, 3:], self.noise))

    @property
    def head(self) -> Array:
        """Poses (frames, 3) of the center of the head link: x, y [m] and the direction faced [rad]."""
        return _head(self.tracked, self.body, self.view.camera, self.size, self.scale)

    @property
    def head_sd(self) -> Array:
        """Standard deviations (frames, 3) of the head poses [m, m, rad]."""
        sd = np.maximum(_sd(self.tracked)[:, :3], self.head_noise)
        if self.scale == "fish":  # a wrong size scales all places about the point below the camera
            away = self.tracked.unknowns[:, :2] - self.view.camera.place[:2]
            sd[:, :2] = np.hypot(sd[:, :2], self.tuning.size_sd * away)
        return np.asarray(sd)

    def record(self) -> dict[str, Any]:
        """Return the results for JSON, with units in the names."""
        state, groups = self.tracked.state, self.body.groups
        seen = self.tracked.seen[np.isfinite(self.tracked.offset)] >= MIN_SEEN
        return {
            "name": self.name,
            "file": self.view.film.file,
            "frames": len(state),
            "frames_used": sum(map(len, self.stretches)),
            "recordings": len(self.stretches),
            "frame_rate_hz": self.view.film.rate,
            "states": {STATES[k]: int((state == k).sum()) for k in range(len(STATES))},
            "camera_off_vertical_deg": math.degrees(self.view.camera.off_vertical),
            "fish_px": float(self.body.length.sum()) * self.size / self.view.pixel,
            "contrast_gray": self.view.contrast,
            "edge_offset_px": float(np.median(self.tracked.offset[state == OK])),
            "length_ratio": self.size,
            "length_ratio_sd": self.tuning.size_sd,
            "width_factor": math.exp(self.tuning.girth),
            "widths_learned": self.body.learned,
            "sections_file_off": self.body.file_off,
            "scale": self.scale,
            "seen": dict(zip(groups, (float(seen[:, k].mean()) for k in links_of(self.body)), strict=True)),
            "noise_deg": np.degrees(self.noise),
            "noise_tau_s": self.memory,
            "head_sd_mm": 1e3 * self.head_noise[:2],
            "yaw_sd_deg": float(np.degrees(self.head_noise[2])),
            "beat_hz": None if self.beat is None else self.beat.frequency,
            "beats": None if self.beat is None else self.beat.beats,
            "amplitude_deg": None if self.beat is None else np.degrees(self.beat.amplitude),
            "warnings": self.warnings,
        }

    @property
    def memory(self) -> float:
        """Correlation time [s] of the noise of the joint angles."""
        return 1 / self.view.film.rate if self.beat is None else self.beat.memory

    @property
    def warnings(self) -> list[str]:
        """Sentences that advise the user on doubtful results."""
        sentences = []
        if abs(self.size - 1) > WARN_SIZE_ERROR:
            percent = f"{100 * abs(self.size - 1):.1f} % {'longer' if self.size > 1 else 'shorter'}"
            measure = "the fish's own length" if self.scale == "fish" else "the camera"
            sentences.append(
                f"{self.name}: the fish looks {percent} than the robot: check the camera's height, the depth of the "
                f"fish and its length. Lengths are measured by {measure}."
            )
        if self.body.measured and abs(girth := 100 * (math.exp(self.tuning.girth) - 1)) > WARN_GIRTH:
            width = f"{abs(girth):.0f} % {'wider' if girth > 0 else 'narrower'}"
            sentences.append(
                f"{self.name}: the fish looks {width} than its sections: check them. The film's widths are used."
            )
        if self.body.file_off:
            sentences.append(
                f"{self.name}: the widths of the file have another shape than those of the fish, by "
                f"{100 * self.body.file_off:.0f} % of its area, so the film's are used and written: is the file of "
                "another robot, or damaged? Measure the sections anew."
            )
        elif self.body.learned:
            sentences.append(
                f"{self.name}: the widths are learned from the film: measure the sections for the best angles."
            )
        if self.beat is None:
            sentences.append(
                f"{self.name}: no steady beat was found, so the noise of ripples is unknown, and the errors are those "
                "of the pixels alone: film six beats of a steady gait."
            )
        elif self.beat.beats < 6:
            sentences.append(f"{self.name}: {self.beat.beats:.1f} beats are few: six show the noise well.")
        if self.view.motion > MOVES:
            sentences.append(
                f"{self.name}: the tank moves by {self.view.motion:.2g} px or more in the picture, and so do all "
                "places: fix the camera, or keep moving light off the floor."
            )
        if forward(self.tracked) < -BACKWARD * float(self.body.length.sum()):
            sentences.append(f"{self.name}: the robot moves tail first: is the film played backward?")
        if still := sum(repeats_of(self.head[frames][:, np.newaxis, :2], within=STILL) for frames in self.stretches):
            sentences.append(f"{self.name}: {still} frames repeat the one before: did the camera drop frames?")
        sentences += [f"{self.name}: {jump}" for jump in jumps(self.stretches, self.tracked.time)]
        if unused := len(self.tracked.state) - sum(map(len, self.stretches)):
            why = [f"{(self.tracked.state == k).sum()} {STATES[k]}" for k in FIXES if (self.tracked.state == k).any()]
            sentences.append(f"{self.name}: {unused} frames are left out ({', '.join(why) or 'in short parts'}).")
        return sentences


def track_film(
    robot: Robot,
    path: str | Path,
    camera: Camera,
    *,
    depth: float,
    sections: str | Path | None = None,
    scale: str = "fish",
    frame_rate: float | None = None,
    journal: Journal | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> FilmRun:
    """Track a robot through a film.

    depth: of the fish [m]; sections: CSV file of widths and heights; scale: lengths follow from that of the "fish" or
    from the "camera"; frame_rate: at which it was filmed [Hz], if the file has another one.
    """
    film = open_film(path, frame_rate)
    try:
        body, journal = body_of(robot, sections), journal or Journal(None, {})
        return _tracked(robot, film, camera, depth, body, scale, journal, progress)
    except InputError as error:
        if error.fix in FIXES.values():  # frames that the fish is not found in, for they may not be of the camera
            check_made(film)
        raise


def _tracked(
    robot: Robot,
    film: Film,
    camera: Camera,
    depth: float,
    body: Body,
    scale: str,
    journal: Journal,
    progress: Callable[[int, int], None],
) -> FilmRun:
    """Return the tracked run of a film."""
    view, samples = view_of(film, camera, depth, body)
    body, tuning = tune(view, body, body_of(robot), samples)
    del samples
    if abs(math.exp(tuning.size) - 1) > MAX_SIZE_ERROR:
        percent = 100 * (math.exp(tuning.size) - 1)
        rule, fix = (
            f"must look as long as the robot, within {100 * MAX_SIZE_ERROR:g} %",
            ("check the robot's length, the camera's height and focal length, and the depth of the fish"),
        )
        raise InputError(rule, file=film.file, key="the fish", value=f"{percent:+.1f} % longer", fix=fix)
    tracker = Tracker(view, body, tuning)
    tracked = track(tracker, journal, progress)
    if forward(tracked) < -BACKWARD * float(body.length.sum()):
        reversed_run = track(tracker, journal, progress, turn=True)
        tracked = reversed_run if (reversed_run.state == OK).sum() > 0.8 * (tracked.state == OK).sum() else tracked
    stretches = _check(tracked, body, film.file)
    frames = np.concatenate(stretches)
    tracked.unknowns[frames, 2] = np.unwrap(tracked.unknowns[frames, 2])
    beat = beat_of(tracked.time[frames], tracked.unknowns[frames, 3:])
    head = _head(tracked, body, camera, math.exp(tuning.size), scale)[frames]
    noise = np.median(_sd(tracked)[frames, :3], axis=0)
    noise = noise if beat is None else np.maximum(path_noise(tracked.time[frames], head, beat.frequency), noise)
    return FilmRun(Path(film.file).stem, view, body, tuning, tracked, beat, noise, scale, stretches)


def write_film_run(run: FilmRun, robot: Robot, output: str | Path, comment: str) -> list[str]:
    """Write the joint angles and head poses of a run, and a manifest of them; return the names of the files."""
    folder, files, recordings = Path(output).parent, [], []
    for k, frames in enumerate(run.stretches):
        name = run.name if len(run.stretches) == 1 else f"{run.name}-{k + 1}"
        own = (run.tracked.time[frames], run.angle[frames], run.angle_sd[frames], run.head[frames], run.head_sd[frames])
        entry, written = write_recording(folder, name, run.body.groups, *own, comment=comment)
        entry["joints"]["noise_deg"] = [float(f"{sd:.4g}") for sd in np.degrees(run.noise)]
        entry["joints"]["noise_tau_s"] = float(f"{run.memory:.4g}")
        recordings.append(entry)
        files += written
    if run.body.learned:
        place = "film-sections" if run.body.file_off else "sections"  # never overwrite the sections file of the user
        path = folder / f"{run.name}-{place}.csv"
        half_sizes = np.sqrt(run.body.section[::STATION_STEP]) * [math.exp(run.tuning.girth), 1.0]
        columns = (run.body.stations[::STATION_STEP], *(2 * half_sizes).T)
        columns_csv({}, dict(zip(COLUMNS, columns, strict=True))).write(path)
        files.append(str(path))
    document = {"format": 1, "robot": robot.name, "recordings": recordings}
    write_atomically(output, manifest_text(document, comment).encode())
    return [*files, str(output)]


def _sd(tracked: Tracked) -> Array:
    """Return standard deviations (frames, 3 + groups) [m, rad] of pose and joint angles due to the noise of pixels."""
    return np.asarray(np.sqrt(np.einsum("fii->fi", tracked.covariance)))


def _head(tracked: Tracked, body: Body, camera: Camera, size: float, scale: str) -> Array:
    """Return poses (frames, 3) of the center of the head link: x, y [m] and the direction faced [rad].

    A wrong depth or height scales all places about the point below the camera; scale "fish" divides that out by `size`.
    """
    x, y, heading = tracked.unknowns[:, :3].T
    half = body.length[0] / 2 * size
    place = np.column_stack([x + half * np.cos(heading), y + half * np.sin(heading)])
    below = np.array(camera.place[:2])
    return np.column_stack([below + (place - below) / (size if scale == "fish" else 1.0), heading + math.pi])


def _check(tracked: Tracked, body: Body, file: str) -> tuple[Frames, ...]:
    """Return the frames in use, an array per stretch; raise an error if too few frames show the fish."""
    state, count = tracked.state, len(tracked.state)
    check_seen(body, tracked.seen[np.isfinite(tracked.offset)], file)
    tracked_frames = stretches_of(tracked.time, np.flatnonzero(state == OK))
    stretches = split_takes(tracked_frames, tracked.unknowns[:, :2], float(body.length.sum()))
    used = sum(map(len, stretches))
    if used < MIN_OK * count:
        worst = max(FIXES, key=lambda k: int((state == k).sum()))
        value = f"so in {used} of {count}; in {(state == worst).sum()} it is {STATES[worst]}"
        rule = f"must show one fish, whole, in {100 * MIN_OK:g} % of its frames"
        raise InputError(rule, file=file, value=value, fix=FIXES[worst])
    return stretches


def split_takes(stretches: Sequence[Frames], place: Array, length: float) -> tuple[Frames, ...]:
    """Split stretches of frames where the fish's place (frames, 2) [m] jumps; drop short parts. length: fish's [m]."""
    parts: list[Frames] = []
    for frames in stretches:
        step = np.linalg.norm(np.diff(place[frames], axis=0), axis=1) / np.diff(frames)
        far = step > max(JUMP * length, JUMP_STEPS * float(np.median(step)))
        parts += np.split(frames, np.flatnonzero(far) + 1)
    return tuple(part for part in parts if len(part) >= MIN_SAMPLES)


def jumps(stretches: Sequence[Frames], time: Array) -> list[str]:
    """Return a warning for each jump of the fish, with the time [s] of the last frame before it."""
    return [
        f"the fish jumps after {time[one[-1]]:.2f} s, so the film is taken as several recordings: were films joined?"
        for one, other in pairwise(stretches)
        if other[0] == one[-1] + 1
    ]
