"""Give a result to the user: JSON or tables on the terminal, the data as CSV or NetCDF, a figure."""

from __future__ import annotations

import contextlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import typer

from hypertuna.cli.console import command_line, print_json, print_lines, print_written
from hypertuna.errors import InputError

R = TypeVar("R")


def emit(
    result: R,
    *,
    record: Callable[[R], Mapping[str, Any]],
    lines: Callable[[R], Iterable[Any]],
    as_json: bool,
    output: str | None = None,
    csv: Callable[[R], str] | None = None,
    dataset: Callable[[R], Any] | None = None,
    plot: str | None = None,
    figure: str = "",
    drawn: Sequence[Any] | None = None,
    written: Sequence[str | None] = (),
    failed: bool = False,
) -> None:
    """Write the files that are asked for, and print a result as one JSON object or as tables and sentences.

    `record` makes the JSON object, `lines` the tables and sentences, `csv` and `dataset` (default: the result's own)
    the content of `output`. `figure` names the function, as "package.module:function", that draws the arguments `drawn`
    (default: the result). `written` names files that are written already. A result that `failed` is printed first,
    since it may have nothing to draw, and ends with exit code 1.
    """

    def show() -> None:
        print_json(record(result)) if as_json else print_lines(lines(result))

    if failed:
        show()
    if plot is not None:
        draw(figure, plot, *((result,) if drawn is None else drawn))
    if output is not None:
        _write(result, output, csv, dataset)
    if not failed:
        show()
    if not as_json:
        print_written(plot, output, *written)
    if failed:
        raise typer.Exit(1)


def draw(figure: str, path: str, *arguments: Any, **options: Any) -> None:
    """Draw to a file; what draws is imported only now, because the import takes longer than most results."""
    function = pkgutil.resolve_name(figure)
    if path.lower().endswith(".gif"):
        function(*arguments, path, **options)
        return
    from hypertuna.figures import save

    save(function(*arguments, **options), path)


@contextlib.contextmanager
def refused(as_json: bool) -> Iterator[None]:
    """Print bad input as a JSON object too, with the parts of its sentence."""
    try:
        yield
    except InputError as error:
        if as_json:
            parts = {key: getattr(error, key) for key in ("file", "key", "rule", "value", "fix")}
            print_json({"valid": False, "error": str(error)} | parts)
        raise


def made_by(robot: Any, **facts: Any) -> dict[str, Any]:
    """Return what made a result: version, robot, model, command, and more facts."""
    from hypertuna.description.provenance import provenance

    return provenance(robot) | {"command": command_line()} | facts


def _write(result: Any, output: str, csv: Callable[[Any], str] | None, dataset: Callable[[Any], Any] | None) -> None:
    """Write the data of a result to a .csv or a .nc file."""
    from hypertuna.io.files import write_atomically, write_netcdf

    if csv is not None and output.lower().endswith(".csv"):
        write_atomically(output, csv(result).encode())
        return
    data = (result.dataset() if dataset is None else dataset(result)).copy()  # shallow: of a dataset, or a tree of them
    data.attrs["command"] = command_line()
    write_netcdf(data, output)
