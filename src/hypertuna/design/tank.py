"""Design of tank runs in a file, which names the next runs, takes their results and continues after an interruption."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse, robot_of
from hypertuna.design.checks import check_gaits, check_new, check_size, check_stride, renamed
from hypertuna.design.criterion import CHECK, WISHES, Design, design
from hypertuna.design.kinds import RUN_KINDS
from hypertuna.design.posterior import Posterior, infer
from hypertuna.design.prediction import Row, predict
from hypertuna.design.runs import (
    BIASES,
    Measurement,
    TankRun,
    Trial,
    bias_ends,
    candidate_gaits,
    measurements,
    run_of,
    run_record,
    speeds_of,
    swims,
    target_gaits,
)
from hypertuna.design.steps import MISSED, Step, warnings_of
from hypertuna.design.unknowns import Unknowns, unknowns_of
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.state import TankState
from hypertuna.ranges import Range, check_name
from hypertuna.trials.plausibility import implausible_runs
from hypertuna.trials.steady import SteadyRun

ASKED = re.compile(r"run-(\d+)")  # names of the runs that a design asks for
TARGETS = 30  # gaits whose prediction is to be narrowed
WIDTH = Range(min=0.001, max=1, unit="1")
RUNS = Range(min=1, max=24)
NORMAL = 1.96  # standard deviations to either side hold 95 % of normal errors
NARROWED = 0.95  # of a standard deviation: coefficients that a run narrows less are not listed
LEAST = 1.1  # of the standard deviation that all runs together would leave


@dataclass(frozen=True)
class Choice:
    """A run to make next, with its expected results and what it narrows."""

    name: str
    run: TankRun
    why: str  # narrows, check or repeat
    expected: Mapping[str, tuple[float, float]]  # by quantity: value [SI], half width of its 95 % interval, relative
    half_width: float  # of the targets' logarithm after the run
    narrowed: Mapping[str, tuple[float, float]]  # by coefficient: standard deviation before and after


@dataclass(frozen=True)
class NextRuns(Plotted, Tabular):
    """The next runs of a design, and the steps so far."""

    robot: Robot
    want: str
    width: float  # that the half width is to reach, relative
    half_width: float  # that it has
    choices: tuple[Choice, ...]
    steps: tuple[Step, ...]
    unknowns: Unknowns
    sd: Array  # (n,) of the scaled coefficients now
    never: Array  # (n,) that all runs in this tank would leave
    stop: str  # why the design is complete; empty while it goes on
    warnings: tuple[str, ...]

    @property
    def subject(self) -> str:
        """The quantity of the target gaits that is to be known, in words."""
        return (WISHES[self.want] or "speed").replace("_", " ")


class TankDesign(TankState):
    """A design whose runs a tank makes; its file is the whole state: opened again, the design goes on.

    Parameters
    ----------
    path : str, Path or None
        File of the state; None keeps nothing.
    robot : Robot, str or Path, optional
        For a new design: a robot that `hypertuna identify -o` wrote, or any other. The file holds it from then on.
    want : str
        What to know: "speed" or "cost" of gaits, the rate of "turn" of bent gaits, or the "coefficients".
    width : float
        Half width of the target gaits' 95 % interval that ends the design, relative [1].
    bounds : mapping of str to (float, float), optional
        Bounds of the gaits in Hz and degrees, in place of the robot's, as the option ``--bounds`` names them.
    prior : mapping of str to float, optional
        Factors by which the robot's coefficients may be off, by name, in place of those of [fit] and of handbooks [1].
    tow : bool
        Whether the tank has a carriage that tows the robot and measures its drag.
    hold : bool
        Whether it has a gauge that holds the head of the beating robot and measures its thrust.
    glide : bool
        Whether the robot can be let go, straight and in motion, and its speed be tracked.

    Examples
    --------
    >>> with TankDesign(None, "rexeel") as tank:
    ...     tank.ask().choices[0].name
    'run-01'
    """

    kind, names = "design", frozenset(("robot", "want", "width", "bounds", "prior", "tow", "hold", "glide"))
    command, example, ignored = "design ask", "--robot fit.toml", ("isa", "version")  # measurements outlive both

    def __init__(
        self,
        path: str | Path | None,
        robot: Robot | str | Path | None = None,
        *,
        want: str = "speed",
        width: float = 0.03,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        prior: Mapping[str, float] | None = None,
        tow: bool = False,
        hold: bool = False,
        glide: bool = False,
    ) -> None:
        options: dict[str, Any] | None = None
        if robot is not None:
            equipment = {"tow": tow, "hold": hold, "glide": glide}
            aims = {"want": want, "width": width, "bounds": dict(bounds or {}), "prior": dict(prior or {})}
            given = robot_of(robot)
            options = {"robot": given.document()} | aims | equipment
            if path is not None and Path(path).exists():
                begun = self._options_of(path)["robot"].get("name")
                if begun != given.name:
                    fix = "leave out --robot, or give another state"
                    raise InputError("is a design of another robot", file=str(path), value=str(begun), fix=fix)
        self.steps: list[Step] = []
        super().__init__(path, options)

    def _begin(self, path: str | Path | None, options: Mapping[str, Any]) -> Robot:
        """Set up unknowns, candidates and targets from the options of the file; return the robot."""
        self.want, self.width = check_name(options["want"], WISHES, "want", "wish"), float(options["width"])
        WIDTH.check(self.width, "width", "give the half width of the prediction, such as 0.03")
        robot = parse(options["robot"], file=str(path or "robot"))
        self.unknowns = unknowns_of(robot, options["prior"] or None)
        self._choose_from(options)
        return robot

    def _replay(self, record: Mapping[str, Any], place: str) -> None:
        """Add the step of a record of the journal."""
        self.steps.append(_step_of(record, place))

    @cached_property
    def posterior(self) -> Posterior:
        """Posterior after the runs."""
        return infer(self.unknowns, self.results)

    def _choose_from(self, options: Mapping[str, Any]) -> None:
        """Set candidates and targets, without gaits that the model does not swim forward."""
        robot = self.unknowns.robot
        space = gait_bounds(robot, {name: tuple(ends) for name, ends in options["bounds"].items()})
        target, turns = WISHES[self.want] or "speed", self.want == "turn"
        if turns and not bias_ends(space, robot).any():
            rule, fix = (
                "must leave a range of bias to a design of turns",
                "give --bounds bias=0:20, or correct the file",
            )
            raise InputError(rule, file=robot.file, key="gait_bounds.bias_deg", value="0", fix=fix)
        gaits = swims(candidate_gaits(space, robot, (0.0, *BIASES) if turns else (0.0,)))
        target_runs = swims(target_gaits(space, robot, TARGETS, BIASES if turns else (0.0,)))
        rows = [Row(run, "speed") for run in gaits] + [Row(run, target) for run in target_runs]
        logs = predict(self.unknowns, self.unknowns.mean, rows).log
        finite = np.isfinite(logs)
        self.candidates = [run for run, good in zip(gaits, finite, strict=False) if good]
        self.targets = [row for row, good in zip(rows[len(gaits) :], finite[len(gaits) :], strict=True) if good]
        if not self.candidates or not self.targets:
            rule, fix = "must hold gaits that the model swims forward", "give other --bounds, or correct the robot file"
            raise InputError(rule, key="the range of gaits", value="none", fix=fix)
        speeds = speeds_of(np.exp(logs[: len(gaits)][finite[: len(gaits)]]))
        swum = [run.gait for run in self.candidates if run.gait is not None]
        for kind in RUN_KINDS.values():
            if kind.needs and options[kind.needs]:
                self.candidates += [TankRun(kind.key, *motion) for motion in kind.choices(swum, speeds)]

    @property
    def results(self) -> list[Measurement]:
        """All results, in the order of the runs."""
        return [result for step in self.steps for result in step.results]

    def ask(self, count: int = 1) -> NextRuns:
        """Return the next runs: each narrows most after those before it, and every fourth is a check.

        Parameters
        ----------
        count : int
            Number of runs to make before the next call.

        Returns
        -------
        NextRuns
        """
        RUNS.check(count, "runs", "ask again after the first runs")
        design_now, width = (
            design(self.posterior, self.want, self.candidates, self.targets),
            half_width(self.posterior, self.targets),
        )
        never, choices = design_now.never(), []
        stop = self._stop(width, design_now, never)
        for k in range(len(self.steps), len(self.steps) + (0 if stop else count)):
            check = (k + 1) % CHECK == 0
            run = design_now.farthest() if check else design_now.best()
            why = "check" if check else "repeat" if run in design_now.made else "narrows"
            design_after = design_now.after([run])
            choices.append(self._choice(f"run-{k + 1:02d}", run, why, design_now, design_after))
            design_now = design_after
        warnings = warnings_of(self.posterior, self.steps, [choice.run for choice in choices], never)
        sd, robot = self.posterior.coefficients[1], self.unknowns.robot
        unknowns, steps = self.unknowns, tuple(self.steps)
        return NextRuns(
            robot, self.want, self.width, width, tuple(choices), steps, unknowns, sd, never, stop, tuple(warnings)
        )

    def tell(self, trials: Sequence[Trial], day: str = "") -> list[str]:
        """Take the results of runs, in the order in which they were made; those of one run follow each other.

        Parameters
        ----------
        trials : sequence of SteadyRun, TurnRun, PowerRun, Tow, HeldThrust, Glide or Measurement
            At least one. If one of them is refused, none is kept.
        day : str
            Name of the day, whose runs share an offset.

        Returns
        -------
        list of str
            Sentences on runs that have the name of one that is asked for, and another gait.
        """
        results = [result for trial in trials for result in measurements(trial, day)]
        if not results:
            raise InputError("must have at least one result", key="tell", value="none", fix="give the measured values")
        notes = self._check(trials, results)
        infer(self.unknowns, [*self.results, *results])
        check_size(results, infer(self.unknowns, []))
        steps, posterior = list[Step](), self.posterior
        for _, group in groupby(results, key=lambda result: (result.run, result.name)):
            step, posterior = self._made(tuple(group), posterior)
            steps.append(step)
        for step in steps:
            self._journal.append(_record_of(step))
            self.steps.append(step)
        self.posterior = posterior
        return notes

    def _check(self, trials: Sequence[Trial], results: Sequence[Measurement]) -> list[str]:
        """Refuse results that were entered before or are in another unit; return sentences on names of other runs.

        Steady runs of candidates are plausible; others are checked.
        """
        robot = self.unknowns.robot
        check_new(results, self.results)
        check_gaits(results, robot)
        check_stride(results, robot)
        steady = [trial for trial in trials if isinstance(trial, SteadyRun)]
        own = [trial for trial in steady if TankRun("steady", trial.gait) not in self.candidates]
        for error in implausible_runs(own, robot)[0]:
            raise error
        last = max((int(match[1]) for one in results if (match := ASKED.fullmatch(one.name))), default=0)
        count = last - len(self.steps)
        return renamed(results, [(one.name, one.run) for one in self.ask(count).choices] if count in RUNS else [])

    def _made(self, results: tuple[Measurement, ...], before: Posterior) -> tuple[Step, Posterior]:
        """Return the step of a new run, and the posterior after it; before: the posterior of the runs so far."""
        mean, sd = before.predict([Row(result.run, result.quantity) for result in results])
        spread = np.hypot(sd, [math.hypot(result.noise, before.day) for result in results])
        after = infer(self.unknowns, [*before.results, *results])
        predicted = tuple(zip(mean.tolist(), spread.tolist(), strict=True))
        sds = tuple(after.coefficients[1].tolist())
        return Step(results, predicted, half_width(after, self.targets), sds, after.size), after

    def _choice(self, name: str, run: TankRun, why: str, plan: Design, after: Design) -> Choice:
        """Return a choice of a run, with its expected results and what it narrows."""
        rows = [Row(run, plan.rows[k].quantity) for k in plan.places[run]]
        mean, sd = self.posterior.predict(rows)
        expected = {row.quantity: (math.exp(m), NORMAL * s) for row, m, s in zip(rows, mean, sd, strict=True)}
        pairs = zip(self.unknowns.names, plan.sd().tolist(), after.sd().tolist(), strict=True)
        narrowed = {coefficient: (old, new) for coefficient, old, new in pairs if new < NARROWED * old}
        return Choice(name, run, why, expected, NORMAL * after.width(), narrowed)

    def _stop(self, width: float, plan: Design, never: Array) -> str:
        """Return why the design is complete, empty if it is not: narrow enough, and the last check agreed."""
        checks = self.steps[CHECK - 1 :: CHECK]
        if not checks or checks[-1].off > MISSED:
            return ""
        if self.want == "coefficients":
            all_known = np.all(plan.sd() <= LEAST * never)
            return "Complete: no run in this tank narrows a coefficient much further." if all_known else ""
        sentence = f"Complete: the {self.targets[0].quantity.replace('_', ' ')} of the target gaits is known within"
        return f"{sentence} {100 * width:.2g} %, and the last check held." if width <= self.width else ""


def half_width(posterior: Posterior, targets: Sequence[Row]) -> float:
    """Return the rms half width of the 95 % intervals of the targets' logarithms."""
    return NORMAL * float(np.sqrt(np.mean(posterior.predict(targets)[1] ** 2)))


def _record_of(step: Step) -> dict[str, Any]:
    """Return a step as a record of the journal."""
    measured = [
        {"name": result.name, "quantity": result.quantity, "value": result.value, "sd": result.sd, "day": result.day}
        for result in step.results
    ]
    state = {name: getattr(step, name) for name in ("predicted", "half_width", "sd", "discrepancy")}
    return {"run": run_record(step.run), "told": measured} | state


def _step_of(record: Mapping[str, Any], place: str) -> Step:
    """Return the step that a record of the journal describes; `place` names it in errors."""
    try:
        run = run_of(record["run"])
        results = tuple(Measurement(run, **values) for values in record["told"])
        predicted = tuple((float(mean), float(sd)) for mean, sd in record["predicted"])
        sds = tuple(float(sd) for sd in record["sd"])
        return Step(results, predicted, float(record["half_width"]), sds, float(record["discrepancy"]))
    except (KeyError, TypeError, ValueError):
        rule, fix = "holds no run of a design", "use the version of hypertuna that wrote it"
        raise InputError(rule, file=place, fix=fix) from None
