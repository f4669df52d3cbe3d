"""The commands `hypertuna design ask` and `hypertuna design tell`: which run the tank makes next."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import attended
from hypertuna.cli.emit import emit
from hypertuna.cli.experiment import STEADY, check_later, check_one_source, gait_row
from hypertuna.cli.search import bounds_of
from hypertuna.cli.streams import note
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.design.criterion import WISHES
from hypertuna.design.kinds import RUN_KINDS
from hypertuna.design.runs import QUANTITIES, Measurement, Trial, run_record
from hypertuna.design.tank import NextRuns, TankDesign
from hypertuna.errors import InputError
from hypertuna.identification.names import split_names
from hypertuna.io.files import Csv, rows_csv
from hypertuna.trials.decay import MIN_ROWS
from hypertuna.trials.kinds import KINDS, rigid_in
from hypertuna.trials.numbers import TurnRun
from hypertuna.trials.steady import COLUMNS as STEADY_COLUMNS
from hypertuna.trials.steady import MEASURED, SteadyRun
from hypertuna.trials.tables import read_runs
from hypertuna.trials.trials import check_no_track

COMMA = re.compile(r"\d+,\d+")  # a number with a decimal comma, or two numbers

State = Annotated[str, opt.text("--state", "File that stores the design; created by the first ask.", "FILE")]
Day = Annotated[
    str | None,
    opt.text(
        "--day", "Name of the day, whose runs share an offset, such as 2026-05-04. (default: that of the last run)"
    ),
]


def _prior(text: str, key: str) -> parsing.Setting:
    """Return name and factor from NAME=FACTOR; key: the option, for errors."""
    return parsing.setting(text, key, "a factor such as 2")


@dataclass(frozen=True)
class DesignOptions:
    """Options of a design of tank runs, which its first ask takes."""

    want: Annotated[
        str,
        opt.word("--want", tuple(WISHES), "What to know: speed, rate of turn or cost of gaits, or the coefficients."),
    ] = "speed"
    width: Annotated[
        float, opt.number("--width", "percent", "Half width in percent of the 95 % interval that is enough.")
    ] = 3.0
    bounds: opt.Bounds = None
    prior: Annotated[
        list[Any] | None,
        opt.option(
            ("--prior",),
            "Factor by which the robot's value of a coefficient may be off; repeatable. (default: the covariance of "
            "the robot's fit, and for other coefficients the factors of data/published/bounds.toml)",
            "NAME=FACTOR",
            _prior,
        ),
    ] = None
    tow: Annotated[bool, opt.flag("--tow", "The tank has a carriage that tows the robot and measures its drag.")] = (
        False
    )
    hold: Annotated[
        bool,
        opt.flag("--hold", "The tank has a gauge that holds the head of the beating robot and measures its thrust."),
    ] = False
    glide: Annotated[
        bool, opt.flag("--glide", "The robot can be let go, straight and in motion, and its speed be tracked.")
    ] = False

    def arguments(self) -> dict[str, Any]:
        """Return the options as arguments of `TankDesign`."""
        prior = {name: factor for names, factor in self.prior or [] for name in split_names(names)}
        common = {"want": self.want, "width": self.width / 100}
        common |= {"tow": self.tow, "hold": self.hold, "glide": self.glide}
        return common | {"bounds": bounds_of(self.bounds), "prior": prior}


@opt.grouped
def ask_command(
    context: typer.Context,
    state: State,
    design: DesignOptions,
    robot: opt.RobotName = "",
    runs: Annotated[int, opt.whole_number("--runs", "Number of runs to make before the next ask.")] = 1,
    output: Annotated[str | None, opt.file("--output", "the runs, to be filled in,", ".csv")] = None,
    report: Annotated[str | None, opt.file("--report", "a page on the design", ".html")] = None,
    plot: opt.Plot = None,
    as_json: opt.AsJson = False,
) -> None:
    """Print the next runs for the tank, what each narrows, and what no run can tell; or that the design is complete.

    The first call defines the design, for a robot file that `hypertuna identify -o` wrote or any other; later ones need
    --state alone. Asking again gives the same runs until the result of one is entered.
    """
    if not robot:
        check_later(context, {"state", "runs", "output", "report", "plot", "as_json"})
    with TankDesign(state, robot or None, **design.arguments()) as tank:
        result = attended("choosing runs", lambda: tank.ask(runs))
    asked = {choice.run.kind for choice in result.choices}
    if rigid := rigid_in(kind for kind in KINDS if kind.key in asked):
        opt.with_rigid_hinge(result.robot, f"in {rigid}")
    if report is not None:
        from hypertuna.reports.results import report as write_page  # here, because its import takes long

        write_page(result, report, title=f"Runs of {result.robot.name}")
    tables = {} if output is None else _tables(result, output)
    for name, table in tables.items():
        table.write(name)
    emit(result, record=_record, plot=plot, written=(*tables, report), as_json=as_json)


def _tables(result: NextRuns, output: str) -> dict[str, Csv]:
    """Return the CSV tables of the next runs to be filled in, by file: one per kind, the first named `output`."""
    rows: dict[type[Any], list[dict[str, Any]]] = {}
    for choice in result.choices:
        kind, gait, u = RUN_KINDS[choice.run.kind], choice.run.gait, choice.run.u
        trial = TurnRun if "turn_rate" in choice.expected else kind.trials[0]
        columns = STEADY_COLUMNS if trial is SteadyRun else trial.columns
        row = gait_row(result.robot, choice.name, gait) if gait is not None else {columns["name"]: choice.name}
        row |= {columns["u"]: f"{u:g}"} if u and not kind.series else {}
        row |= {columns["time"]: ""} if kind.series else {}
        row |= dict.fromkeys(STEADY if trial is SteadyRun else (columns["value"],), "")
        rows.setdefault(trial, []).extend([row] * (MIN_ROWS if kind.series else 1))
    first, keys = Path(output), {kind.trial: kind.key for kind in KINDS}
    names = (f"{first.with_name(f'{first.stem}-{keys[trial]}.csv')}" for trial in [*rows][1:])
    return {name: rows_csv({}, table) for name, table in zip((output, *names), rows.values(), strict=False)}


def tell_command(
    state: State,
    results: Annotated[
        list[str] | None,
        typer.Argument(
            help="CSV files of runs, these or others: what `ask -o` wrote, or tows, held thrusts, powers, glides. Runs "
            "of several files are taken in the order of their names."
        ),
    ] = None,
    value: Annotated[
        list[str] | None,
        opt.text(
            "--value",
            "Speed in m/s, or SPEED,COST_OF_TRANSPORT, or what is expected of the run, in the unit that is printed: "
            "a rate of turn, a drag, a thrust; repeat it for the next runs.",
        ),
    ] = None,
    day: Day = None,
    as_json: opt.AsJson = False,
) -> None:
    """Enter what the runs measured, in the order in which they were made; then the next run is printed."""
    with TankDesign(state) as tank:
        check_one_source(results or None, value)
        last = tank.results[-1].day if tank.results else ""
        when = last if day is None else day
        trials = _of_values(value or [], tank) if not results else _of_files(results, tank.unknowns.robot)
        for sentence in tank.tell(trials, when):
            note(sentence)
        emit(tank.ask(), record=_record, as_json=as_json)


def _of_files(files: Sequence[str], robot: Robot) -> list[Trial]:
    """Return the trials of CSV files, runs of each file in the order of its rows."""
    trials = list[Trial]()
    for file in files:
        check_no_track(file)
        trials += read_runs(file, robot)
    return trials if len(files) == 1 else sorted(trials, key=lambda run: run.name)


def _of_values(texts: Sequence[str], tank: TankDesign) -> list[Trial]:
    """Return trials from the texts of --value, one for each of the next runs in their order."""
    trials = list[Trial]()
    for k, (text, choice) in enumerate(zip(texts, tank.ask(len(texts)).choices, strict=True)):
        key, run, names = f"--value {k + 1}", choice.run, list(choice.expected)
        if RUN_KINDS[run.kind].series:
            rule, fix = "must be a track", "give a CSV file with time_s and speed_m_s: `design ask -o` begins one"
            raise InputError(rule, key=key, value=text, fix=fix)
        names = list(MEASURED) if names[0] == "speed" else names
        low, high = (value * math.exp(side * width) for value, width in [choice.expected[names[0]]] for side in (-1, 1))
        per_si = QUANTITIES[names[0]].per_si
        if COMMA.fullmatch(text) and not (len(names) > 1 and low <= float(text.split(",")[0]) / per_si <= high):
            rule, fix = (
                "must have decimal points",
                f"write {text.replace(',', '.')}, or {text.replace(',', '.0,')} for two",
            )
            raise InputError(rule, key=key, value=text, fix=fix)
        values = parsing.numbers(text, key, " or ".join(QUANTITIES[name].unit for name in names))
        if len(values) > len(names):
            rule, fix = f"must have at most {len(names)} of {', '.join(names)}", f"give {','.join(names).upper()}"
            raise InputError(rule, key=key, value=text, fix=fix)
        fields = {name: v / QUANTITIES[name].per_si for name, v in zip(names, values, strict=False)}
        trials += [Measurement(run, name, v, name=choice.name) for name, v in fields.items()]
    return trials


def _record(result: NextRuns) -> dict[str, Any]:
    """Return the JSON record of the next runs, and of what they are expected to narrow."""
    names = result.unknowns.names
    rows = zip(names, result.unknowns.sd.tolist(), result.sd.tolist(), result.never.tolist(), strict=True)
    return {
        "stop": result.stop,
        "want": result.want,
        "half_width": result.half_width,
        "enough": result.width,
        "runs": [
            {"run": choice.name}
            | run_record(choice.run)
            | {
                "why": choice.why,
                "expected": {name: {"value": v, "half_width": w} for name, (v, w) in choice.expected.items()},
                "half_width": choice.half_width,
                "narrowed": {name: {"before": old, "after": new} for name, (old, new) in choice.narrowed.items()},
            }
            for choice in result.choices
        ],
        "coefficients": [
            {"name": name, "prior_sd": prior, "sd": sd, "never_below": never} for name, prior, sd, never in rows
        ],
        "history": [
            {"run": step.results[0].name}
            | run_record(step.run)
            | {choice.quantity: choice.value for choice in step.results}
            | {"off_sd": step.off, "half_width": step.half_width, "discrepancy": step.discrepancy, "sd": step.sd}
            for step in result.steps
        ],
        "warnings": list(result.warnings),
    } | provenance(result.robot)
