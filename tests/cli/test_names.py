"""Names of commands: a former name still runs its command, and says the present one."""

from typing import Any

import pytest
from typer.main import get_command

from hypertuna.cli.main import COMMANDS, RENAMED, app
from program import Run


@pytest.mark.parametrize("former", RENAMED)
def test_a_former_name_runs_the_command_and_says_the_present_name(former: str, run: Run) -> None:
    present = RENAMED[former]
    code, output, errors = run(former, "--help")
    assert (code, output) == (0, run(*present.split(), "--help")[1])
    assert errors == f"note: `hypertuna {former}` is now `hypertuna {present}`; the next release drops the old name.\n"
    assert former not in COMMANDS
    assert present.split()[0] in COMMANDS


def test_help_fits_into_80_columns_uncut() -> None:
    """Every command and group is walked through; nothing in its help is cut by an ellipsis."""
    groups: list[tuple[Any, Any]] = [(get_command(app), None)]
    count = 0
    while groups:
        command, parent = groups.pop()
        context = command.context_class(command, info_name=command.name or "hypertuna", parent=parent)
        help = command.get_help(context)
        count += 1
        assert max(map(len, help.splitlines())) <= 80, command.name
        assert not [line for line in help.splitlines() if line.endswith("...") and "Usage" not in line]
        groups += [(one, context) for one in getattr(command, "commands", {}).values()]
    assert count > 40
