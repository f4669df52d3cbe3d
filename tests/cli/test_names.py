"""Names of commands: a former name still runs its command, and says the present one."""

import pytest

from hypertuna.cli.main import COMMANDS, RENAMED
from program import Run


@pytest.mark.parametrize("former", RENAMED)
def test_a_former_name_runs_the_command_and_says_the_present_name(former: str, run: Run) -> None:
    present = RENAMED[former]
    code, output, errors = run(former, "--help")
    assert (code, output) == (0, run(*present.split(), "--help")[1])
    assert errors == f"note: `hypertuna {former}` is now `hypertuna {present}`; the next release drops the old name.\n"
    assert former not in COMMANDS
    assert present.split()[0] in COMMANDS
