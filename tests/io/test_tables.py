"""Text files: what is read, and the sentence about what cannot be read."""

from pathlib import Path

import pytest

from hypertuna.errors import InputError
from hypertuna.io.tables import conversion, read_table, read_toml


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


def test_comments_and_empty_lines_of_a_table_are_skipped(tmp_path: Path) -> None:
    file = tmp_path / "speeds.csv"
    file.write_text("# by hand\n\nspeed_m_s\n0.5\n  # again\n0.25\n")
    table = read_table(file)
    assert (table.line, table.head, table.rows) == (3, ["speed_m_s"], [(4, ["0.5"]), (6, ["0.25"])])


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_table_must_be_separated_by_commas(mark: str, tmp_path: Path) -> None:
    file = tmp_path / "speeds.csv"
    file.write_text(f"time_s{mark}speed_m_s\n0{mark}0.5\n")
    with pytest.raises(InputError, match="must be separated by commas"):
        read_table(file)


@pytest.mark.parametrize(
    ("column", "near", "text"),
    [
        ("time_ms", "time_s", " Then divide the numbers by 1000"),
        ("time_min", "time_s", " Then multiply the numbers by 60"),
        ("speed_m_s", "speed_km_h", " Then multiply the numbers by 3.6"),
        ("speed_cm_s", "speed_m_s", " Then divide the numbers by 100"),
        ("angle_deg", "angle_rad", " Then divide the numbers by 57.2958"),
        ("pressure_bar", "pressure_kpa", " Then multiply the numbers by 100"),
        ("frequency_rpm", "frequency_hz", " Then divide the numbers by 60"),
        ("volume_mm3", "volume_ml", " Then divide the numbers by 1000"),
        ("time_s", "speed_m_s", ""),
    ],
)
def test_another_unit_says_how_to_convert(column: str, near: str, text: str) -> None:
    assert conversion(column, near) == text
