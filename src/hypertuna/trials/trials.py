"""Trials: all kinds of measured runs, from any number of files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.description.robot import Robot, robot_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.trials.forms import form_name
from hypertuna.trials.importers import import_folder
from hypertuna.trials.kind import Kind
from hypertuna.trials.kinds import KINDS, kind_of
from hypertuna.trials.manifest import Recording, parse_manifest, read_manifest
from hypertuna.trials.plausible_numbers import contradictions
from hypertuna.trials.radio_log import steady_runs
from hypertuna.trials.steady import SteadyRun
from hypertuna.trials.tables import Run, read_runs

FILMS = (".mp4", ".mov", ".avi", ".mkv", ".m4v", ".webm", ".mts", ".mpg", ".wmv", ".360")  # suffixes


@dataclass(frozen=True)
class Trials(Plotted, Tabular):
    """Measured runs of a robot; names of runs, and of recordings, are unique."""

    members: tuple[Run | Recording, ...] = ()  # in the order of `hypertuna.trials.kinds.KINDS`

    def __post_init__(self) -> None:
        for kind, members in self.kinds.items():
            _check_unique([(trial.name, trial.file) for trial in members], kind.label.split()[-1])
        object.__setattr__(self, "members", tuple(trial for members in self.kinds.values() for trial in members))
        _check_unique([(name, trial.file) for trial in self.members for name in kind_of(trial).runs(trial)], "run")

    @property
    def steady(self) -> tuple[SteadyRun, ...]:
        """The steady runs."""
        return tuple(trial for trial in self.members if isinstance(trial, SteadyRun))

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """The tracked recordings."""
        return tuple(trial for trial in self.members if isinstance(trial, Recording))

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of all runs, in the order of `members`; tracked runs are named RECORDING/RUN."""
        return tuple(name for trial in self.members for name in kind_of(trial).runs(trial))

    @property
    def kinds(self) -> dict[Kind[Any], tuple[Any, ...]]:
        """Trials by kind, without kinds that have none."""
        members = {kind: tuple(one for one in self.members if isinstance(one, kind.trial)) for kind in KINDS}
        return {kind: own for kind, own in members.items() if own}

    def only(self, names: Iterable[str]) -> Trials:
        """Return the trials with only some of the runs; recordings without any of these are left out.

        Parameters
        ----------
        names : iterable of str
            As in `runs`.

        Returns
        -------
        Trials
        """
        chosen = set(names)
        for name in sorted(chosen.difference(self.runs)):
            fix = did_you_mean(name, self.runs)
            raise InputError("must be a run of the trials", key="run", value=shown(name), fix=fix)
        kept = (kind_of(trial).only(trial, chosen) for trial in self.members)
        return Trials(tuple(trial for trial in kept if trial is not None))

    def __add__(self, other: Trials) -> Trials:
        return Trials(self.members + other.members)


@checked
def read_trials(paths: str | Path | Sequence[str | Path], robot: Robot | str | Path) -> Trials:
    """Read trials of a robot from files of any kind.

    Parameters
    ----------
    paths : str, Path or sequence of them
        CSV files of runs, TOML manifests, radio logs (.mcap), or folders of published files.
    robot : Robot, str or Path
        The robot that swam.

    Returns
    -------
    Trials
    """
    robot = robot_of(robot)
    files = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not files:
        raise InputError("must name at least one file", key="trials", fix="give a CSV file, a manifest or a folder")
    return sum((_read(Path(path), robot) for path in files), Trials())


def _read(path: Path, robot: Robot) -> Trials:
    """Read one file or folder."""
    if os.path.isdir(path):
        return Trials(parse_manifest(import_folder(path), robot, folder=Path(), file=str(path)))
    suffix = path.suffix.lower()
    if suffix == ".csv":
        try:
            return Trials(read_runs(path, robot))
        except InputError:
            check_no_track(path)
            raise
    if suffix == ".toml":
        return Trials(read_manifest(path, robot))
    if suffix == ".mcap":
        return Trials(steady_runs(path, robot))
    check_no_track(path)
    rule = "must be a CSV file of steady runs, a TOML manifest, a .mcap log or a folder"
    fixes = {
        "save the table as CSV, with commas between the cells": (".xlsx", ".xls", ".ods", ".numbers"),
        "track the robot through the film: `hypertuna trials track`": FILMS,
    }
    fix = next((text for text, suffixes in fixes.items() if suffix in suffixes), "convert it to one of them")
    raise InputError(rule, file=str(path), fix=fix)


def check_no_track(path: str | Path) -> None:
    """Refuse a file of tracked points with the command that makes a manifest of it."""
    if form := form_name(path):
        fix = f"`hypertuna trials import markers {path} --robot ROBOT -o {Path(path).stem}.toml` makes a manifest of it"
        raise InputError(f"holds tracked points, in the form of {form}", file=str(path), fix=fix)


def _check_unique(names: Sequence[tuple[str, str]], what: str) -> None:
    """Check that names, given in pairs with their files, are unique."""
    first: dict[str, str] = {}
    for name, file in names:
        if name in first:
            value = f"in {first[name]}, too" if first[name] != file else "given twice"
            fix = "give each file once, and each run its own name"
            raise InputError("must be unique", file=file or None, key=f"{what} {name}", value=value, fix=fix)
        first[name] = file


def implausible(trials: Trials, robot: Robot) -> tuple[list[InputError], list[str]]:
    """Return errors on files that must be in wrong units, and warnings about files with unlikely values."""
    results = [kind.implausible(members, robot) for kind, members in trials.kinds.items()]
    errors = [error for own, _ in results for error in own]
    warnings = [text for _, texts in results for text in texts]
    runs = (run for members in trials.kinds.values() for run in members)
    return errors, warnings if errors else [*warnings, *contradictions(runs, robot)]


def split(trials: Trials, validate: float, seed: int) -> tuple[Trials, Trials]:
    """Split trials at random, by run, into training (at least one run) and validation, a fraction of the runs."""
    runs = trials.runs
    count = min(round(validate * len(runs)), len(runs) - 1)
    chosen = {runs[k] for k in np.random.default_rng(seed).permutation(len(runs))[: max(count, 0)]}
    return trials.only([run for run in runs if run not in chosen]), trials.only(chosen)


def digest(trials: Trials) -> str:
    """Return the sha256 of trials, which does not depend on the names of their files."""
    sha = hashlib.sha256()

    def update(value: Any) -> None:
        if is_dataclass(value):
            for field in fields(value):
                if field.name not in ("file", "line", "lines", "columns"):
                    update(getattr(value, field.name))
        elif isinstance(value, np.ndarray):
            sha.update(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, (tuple, list)):
            sha.update(b"[")
            for part in value:
                update(part)
            sha.update(b"]")
        else:
            sha.update(repr(value).encode() + b";")

    for kind in KINDS:
        update(trials.kinds.get(kind, ()))
    return sha.hexdigest()
