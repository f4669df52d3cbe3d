"""Text files that cannot be read: the sentence says what to mend."""

from pathlib import Path

import pytest

from hypertuna.errors import InputError
from hypertuna.io.tables import read_toml


@pytest.mark.parametrize(
    ("text", "fix"),
    [
        ("a = [0.62, 0,22\nb = 1\n", "close the bracket that opens there or on a line above, and write decimals with"),
        ("a = 0,62\n", "write one key a line, and decimals with a point"),
        ("[sources]\na = 1\na = 2\n", "a key is there twice: delete one of the two lines"),
        ("[a]\nb = 1\n[a]\nc = 2\n", "a table is there twice: put its keys under one heading"),
        ("a = tru\n", "correct that line"),
    ],
)
def test_toml_that_cannot_be_read_names_line_and_fix(text: str, fix: str, tmp_path: Path) -> None:
    file = tmp_path / "fish.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=r"must be valid TOML.*line \d") as caught:
        read_toml(file)
    assert fix in str(caught.value)
