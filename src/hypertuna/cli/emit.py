"""Output of a command's result: JSON or tables on the terminal, the data as CSV or NetCDF, a figure."""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import typer

from hypertuna.cli.console import command_line, print_json, print_lines, print_written
from hypertuna.cli.streams import state
from hypertuna.display import card_of, plots
from hypertuna.errors import InputError, InputErrors

if TYPE_CHECKING:
    from hypertuna.io.files import Csv

R = TypeVar("R")


def emit(
    result: R,
    *,
    as_json: bool,
    lines: Callable[[R], Iterable[Any]] | None = None,
    record: Callable[[R], Mapping[str, Any]] | None = None,
    output: str | None = None,
    csv: Callable[[R], "Csv"] | None = None,
    columns: Mapping[str, str] | Sequence[str] = (),
    digits: int | None = 6,
    dataset: Callable[[R], Any] | None = None,
    facts: Callable[[R], Mapping[str, Any]] | None = None,
    plot: str | None = None,
    figure: Callable[[R], Any] | None = None,
    written: Sequence[str | None] = (),
    failed: bool = False,
) -> None:
    """Write the files that are asked for, and print a result as one JSON object or as a card.

    `lines` makes the tables and sentences (default: those of its card), `record` the JSON object (default: the
    result's summary and what made it), `dataset` the content of `output` (default: the result's own, or the result
    itself). A CSV file has its variables `columns`, maybe with the names of their columns, rounded to `digits` (see
    `variable_columns` and `columns_csv`), or is the file that `csv` makes; NAME.csv.json beside it says what made it.
    `facts` are attributes of either file beside those of the dataset. `figure` plots the result (default: as those of
    its class are plotted). `written` names files that are written already. A result that `failed` is printed before its
    files are written, since it may have nothing to draw, and ends the program with exit code 1.
    """

    def show() -> None:
        if as_json:
            notes = {"notes": state["notes"]} if state["notes"] else {}
            print_json({**(_summary(result) if record is None else record(result)), **notes})
        else:
            print_lines(card_of(result).lines() if lines is None else lines(result))

    if failed:
        show()
    if plot is not None:
        save(plots[type(result)](result) if figure is None else figure(result), plot)
    if output is not None:
        if csv is not None and output.lower().endswith(".csv"):
            csv(result).write(output)
        else:
            data = (
                dataset(result) if dataset is not None else result.dataset() if hasattr(result, "dataset") else result
            )
            _write(data, output, {} if facts is None else facts(result), columns, digits)
    if not failed:
        show()
    if not as_json:
        print_written(plot, output, *written)
    if failed:
        raise typer.Exit(1)


def save(figure: Any, path: str) -> None:
    """Write a figure to a file; None is an animation, which is already written."""
    from hypertuna import figures  # imported here, because matplotlib takes longer to import than most results take

    if figure is not None:
        figures.save(figure, path)


@contextlib.contextmanager
def refused(as_json: bool) -> Iterator[None]:
    """With --json, print an InputError raised inside also as a JSON object of its file, key, rule, value and fix."""
    try:
        yield
    except InputError as error:
        if as_json:
            errors = error.errors if isinstance(error, InputErrors) else (error,)
            names = ("file", "key", "rule", "value", "fix")
            rows = [{name: getattr(mistake, name) for name in names} for mistake in errors]
            print_json({"valid": False, "error": str(error)} | rows[0] | {"errors": rows})
        raise


def made_by(robot: Any, **facts: Any) -> dict[str, Any]:
    """Return the provenance of a result: version, robot, model and command, and more facts."""
    from hypertuna.description.provenance import provenance

    return provenance(robot) | {"command": command_line()} | facts


def _summary(result: Any) -> dict[str, Any]:
    """Return the values of a result's summary, with its provenance."""
    return {key: quantity.value for key, quantity in result.summary().items()} | made_by(result.robot)


def _write(
    data: Any, output: str, facts: Mapping[str, Any], columns: Mapping[str, str] | Sequence[str], digits: int | None
) -> None:
    """Write a dataset and more attributes to a .csv or a .nc file."""
    from hypertuna.io.files import columns_csv, variable_columns, write_netcdf

    data = data.copy()  # a shallow copy of the dataset or of the tree of datasets
    data.attrs |= attributes(facts) | {"command": command_line()}
    if output.lower().endswith(".csv"):
        columns_csv(data.attrs, variable_columns(data, columns), digits=digits).write(output)
    else:
        write_netcdf(data, output)


def attributes(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record as attributes that NetCDF can hold: rows flattened by name, texts joined, flags as 0 or 1."""
    flat: dict[str, Any] = {}
    for key, value in record.items():
        rows = value if isinstance(value, list | tuple) else ()
        if rows and isinstance(rows[0], Mapping):
            for row in rows:
                flat |= {f"{row['name']}_{part}".replace("-", "_"): x for part, x in row.items() if part != "name"}
        elif isinstance(value, list | tuple) and all(isinstance(part, str) for part in value):
            flat[key] = "; ".join(value)
        elif value is not None:
            flat[key] = int(value) if isinstance(value, bool) else value
    return flat
