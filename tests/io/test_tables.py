"""Text files: what is read, and the sentence about what cannot be read."""

from pathlib import Path

import pytest

from hypertuna.errors import InputError, InputErrors
from hypertuna.io.door import read_toml
from hypertuna.io.tables import MAX_NAMED, Table, conversion, parse_float, read_table


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


KNOWN = {"time_s": "time", "speed_m_s": "speed", "speed_cm_s": "speed", "note": "note"}
REQUIRED = {"time": "time_s", "speed": "speed_m_s"}


@pytest.mark.parametrize(
    ("head", "sentences"),
    [
        (["speed_m_s", "time_s", "note"], []),
        (["time_s"], ["speed_m_s must be a column, but is missing: add it."]),
        (
            ["time_s", "speed_m_s", "speed_cm_s"],
            ["line 2, speed_cm_s must appear only once, but is speed_m_s, too: remove one of the two."],
        ),
        # near to a column that is required: one mistake, not two
        (["time_s", "sped_m_s"], ["line 2, sped_m_s is not a known column: did you mean speed_m_s?"]),
        (
            ["time_s", "speed_mm_s"],
            ["line 2, speed_mm_s is not a known column: did you mean speed_m_s? Then divide the numbers by 1000."],
        ),
        (
            ["time_s", "speed_m_s", "x", "y"],
            [
                "line 2, x is not a known column: use one of note.",
                "line 2, y is not a known column: use one of those above.",
            ],
        ),
        # more mistakes than columns, none of which is like ours: a file of another kind, so only the first is reported
        (["x"], ["line 2, x is not a known column: use one of time_s, speed_m_s, speed_cm_s, note."]),
        # as many mistakes as columns: all are reported
        (
            ["x", "time_s"],
            [
                "line 2, x is not a known column: use one of speed_m_s, speed_cm_s, note.",
                "speed_m_s must be a column, but is missing: add it.",
            ],
        ),
        # more than columns, but one is like ours
        (
            ["tim_s"],
            [
                "line 2, tim_s is not a known column: did you mean time_s?",
                "speed_m_s must be a column, but is missing: add it.",
            ],
        ),
    ],
)
def test_columns_are_known_given_once_and_not_missing(head: list[str], sentences: list[str]) -> None:
    table = Table("a.csv", 2, head, [])
    if not sentences:
        assert table.keys(KNOWN, REQUIRED, fix="add it") == ["speed", "time", "note"]
        return
    with pytest.raises(InputError) as caught:
        table.keys(KNOWN, REQUIRED, fix="add it")
    errors = caught.value.errors if isinstance(caught.value, InputErrors) else [caught.value]
    assert [str(error) for error in errors] == [f"a.csv: {sentence}" for sentence in sentences]


def test_a_table_of_other_things_with_one_of_our_columns_is_another_file() -> None:
    required = REQUIRED | {"note": "note"}
    with pytest.raises(InputError) as caught:  # speed and note are missing, x and y unknown: 4 mistakes of 3 columns
        Table("a.csv", 1, ["x", "time_s", "y"], []).keys(KNOWN, required, fix="add it", hint=lambda column: "skip it")
    assert str(caught.value) == "a.csv: line 1, x, y are not known columns: skip it."


def number_of(line: int, cells: dict[str, str]) -> tuple[int, float]:
    """Return the line and its number; below 0 it is refused by the names of two keys."""
    value = parse_float(cells["value"])
    if value < 0:
        raise InputError(
            "must be positive", key="value" if value > -10 else "limit", value=cells["value"], fix="add 10"
        )
    return line, value


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        ([["1"], ["2.5"]], ""),
        ([["1"], ["-1"]], "line 4, v_m must be positive, but is -1: add 10."),
        ([["-10"], ["1"]], "line 3, l_m must be positive, but is -10: add 10."),
        ([["1"], ["1", "2"]], "line 4 must have 1 cells, like the line of names, but is 2 long: complete the line"),
        (
            [["-1"], ["-2"]],
            "has 2 rows that cannot be used: line 3, v_m must be positive, but is -1; line 4, v_m",
        ),
        ([["-1"]] * MAX_NAMED, "a.csv: lines 3, 4, 5, 6, 7, v_m must be positive, but is -1: add 10."),
        ([["-1"]] * (MAX_NAMED + 2), "lines 3, 4, 5, 6, 7 and 2 more, v_m must be positive, but is -1: add 10."),
        (
            [["-1"], ["-1"], ["-2"]],
            "has 3 rows that cannot be used: lines 3, 4, v_m must be positive, but is -1; line 5",
        ),
        ([[f"-{k}"] for k in range(1, MAX_NAMED + 3)], "line 7, v_m must be positive, but is -5; and 2 more."),
    ],
)
def test_rows_that_cannot_be_used_are_told_together(cells: list[list[str]], sentence: str) -> None:
    table = Table("a.csv", 2, ["v_m"], list(enumerate(cells, 3)))
    if not sentence:
        assert table.parse(number_of, ["value"]) == [(3, 1.0), (4, 2.5)]
        return
    with pytest.raises(InputError) as caught:
        table.parse(number_of, ["value"], names={"limit": "l_m"})
    assert sentence in str(caught.value)


def test_without_keys_and_names_the_columns_are_their_own() -> None:
    table = Table("a.csv", 1, ["value"], [(2, ["-1"])])
    with pytest.raises(InputError, match=r"^a.csv: line 2, value must be positive, but is -1"):
        table.parse(number_of)
    with pytest.raises(InputError, match=r"^a.csv: line 2 must be positive, but is -10"):
        Table("a.csv", 1, ["value"], [(2, ["-10"])]).parse(number_of)


@pytest.mark.parametrize(
    ("ends", "sizes"),
    [
        (("m_s", "cm_s", "mm_s"), (1000, 10, 1)),
        (("km", "m", "cm", "mm"), (1e6, 1000, 10, 1)),
        (("mpa", "bar", "kpa", "mbar", "pa"), (1e6, 1e5, 1000, 100, 1)),
        (("min", "s", "ms"), (60_000, 1000, 1)),
        (("m3", "l", "ml", "mm3"), (1e9, 1e6, 1000, 1)),
        (("hz", "mhz"), (1000, 1)),
        (("hz", "rpm"), (60, 1)),
        (("m_s", "km_h"), (3.6, 1)),
    ],
)
def test_units_of_columns_have_their_size(ends: tuple[str, ...], sizes: tuple[float, ...]) -> None:
    for own, size in zip(ends, sizes, strict=True):
        factor = size / sizes[-1]
        text = f" Then multiply the numbers by {factor:.6g}" if factor > 1 else ""
        assert conversion(f"x_{own}", f"x_{ends[-1]}") == text
        assert conversion(f"x_{ends[-1]}", f"x_{own}") == text.replace("multiply", "divide")


@pytest.mark.parametrize(
    ("line", "refused"), [("a;b", True), ("a\tb", True), ("a;b,c", False), ("a,b\tc", False), ("a", False)]
)
def test_a_table_is_separated_by_other_marks_only_without_a_comma(line: str, refused: bool, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"{line}\n{line}\n")
    if refused:
        with pytest.raises(InputError, match="must be separated by commas"):
            read_table(tmp_path / "a.csv")
    else:
        assert len(read_table(tmp_path / "a.csv").rows) == 1


@pytest.mark.parametrize(
    ("given", "ours", "change"),
    [
        ("v_cm_s", "v_m_s", "divide the numbers by 100"),
        ("v_mm_s", "v_m_s", "divide the numbers by 1000"),
        ("v_km_h", "v_m_s", "divide the numbers by 3.6"),
        ("x_cm", "x_m", "divide the numbers by 100"),
        ("x_mm", "x_m", "divide the numbers by 1000"),
        ("x_km", "x_m", "multiply the numbers by 1000"),
        ("p_kpa", "p_pa", "multiply the numbers by 1000"),
        ("p_mpa", "p_pa", "multiply the numbers by 1e+06"),
        ("p_mbar", "p_pa", "multiply the numbers by 100"),
        ("p_bar", "p_pa", "multiply the numbers by 100000"),
        ("a_rad", "a_deg", "multiply the numbers by 57.2958"),
        ("r_rad_s", "r_deg_s", "multiply the numbers by 57.2958"),
        ("f_mn", "f_n", "divide the numbers by 1000"),
        ("f_kn", "f_n", "multiply the numbers by 1000"),
        ("p_mw", "p_w", "divide the numbers by 1000"),
        ("p_kw", "p_w", "multiply the numbers by 1000"),
        ("f_mhz", "f_hz", "divide the numbers by 1000"),
        ("n_rpm", "n_hz", "divide the numbers by 60"),
        ("t_ms", "t_s", "divide the numbers by 1000"),
        ("t_min", "t_s", "multiply the numbers by 60"),
        ("v_l", "v_ml", "multiply the numbers by 1000"),
        ("v_mm3", "v_ml", "divide the numbers by 1000"),
        ("v_m3", "v_ml", "multiply the numbers by 1e+06"),
    ],
)
def test_every_unit_by_hand_and_back(given: str, ours: str, change: str) -> None:
    assert conversion(given, ours) == f" Then {change}"
    swapped = {"divide": "multiply", "multiply": "divide"}
    word, _, rest = change.partition(" ")
    assert conversion(ours, given) == f" Then {swapped[word]} {rest}"
    assert conversion(given, given) == conversion(given, f"other{ours}") == ""
