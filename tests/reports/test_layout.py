"""Where parts of a page stand: heights in pixels, sections beside each other, parts that span both columns."""

import pytest

from hypertuna.reports.html import Part, Picture, Section, Table, _heights, _narrow, _rows, _spans, _wide

TEXT = "a" * 55  # one line: 26 px, and 14 between paragraphs
WIDE = Table(["a"], [["x" * 62]])
TABLE = Table(["a", "b"], [["x", 1.0]])


@pytest.mark.parametrize(
    ("part", "heights"),
    [
        (TEXT, [40]),
        ("a" * 56, [66]),
        ("a" * 112, [92]),
        (f"{TEXT}\n\n{'a' * 56}", [40, 66]),
        (Table(["a"], [["x"], ["y"]]), [3 * 36 + 48]),  # a line of 20 px for the caption, and 28 around it
        (Table(["a"], [], "a" * 40, "b" * 34), [36 + 48]),
        (Table(["a"], [], "a" * 40, "b" * 35), [36 + 68]),
        (Picture("p", '<svg viewBox="0 0 200 100"></svg>', "a", "b"), [251 + 48]),  # half of 502 px
        (Picture("p", '<svg viewBox="5 5 100 200"></svg>', "a" * 150, ""), [1004 + 88]),
        (Picture("p", "<svg></svg>", "", ""), [502 + 48]),
    ],
)
def test_heights_of_parts(part: Part, heights: list[float]) -> None:
    assert _heights(part) == heights


@pytest.mark.parametrize(("letters", "wide"), [(61, False), (62, True)])
def test_a_table_is_wide_from_503_pixels_on(letters: int, wide: bool) -> None:
    assert _wide(Table(["a"], [["x" * letters]])) is wide  # 8 a letter and 14 a column
    assert _wide(Table([f"{'x' * letters} y"], [["x"]])) is wide  # heads break between words
    assert _wide(Table(["a", "b"], [["x" * (letters - 12), "x" * 10], ["x", "x"]])) is wide


@pytest.mark.parametrize(
    ("parts", "narrow"),
    [
        ([], False),
        ([TEXT], True),
        ([TEXT] * 2, False),  # a column each
        ([TEXT] * 3, True),  # 80 beside 40 px
        ([TEXT] * 5, True),  # 120 beside 80: a third of the taller is empty
        ([TEXT] * 7, False),  # 160 beside 120: a quarter
        ([TABLE], True),
        ([WIDE], False),
        ([TEXT, Table(["a"], [["x"]] * 9)], True),
    ],
)
def test_a_section_is_narrow_that_leaves_much_of_a_column_empty(parts: list[Part], narrow: bool) -> None:
    assert _narrow(Section("", parts)) is narrow


def test_narrow_sections_stand_two_by_two() -> None:
    sections = {"n": Section("n", [TEXT]), "w": Section("w", [TEXT, TEXT])}
    for order, rows in (
        ("n", "n"),
        ("nn", "nn"),
        ("nnn", "nn n"),
        ("nwn", "n w n"),
        ("wnn", "w nn"),
        ("nnnn", "nn nn"),
    ):
        found = _rows([sections[one] for one in order])
        assert " ".join("".join(one.title for one in row) for row in found) == rows


@pytest.mark.parametrize(
    ("order", "spans"),
    [
        ("t", "1"),
        ("tt", "00"),
        ("w", "1"),
        ("tw", "11"),
        ("ttw", "001"),
        ("twt", "111"),
        ("wttw", "1001"),
        ("wtwtt", "11100"),
    ],
)
def test_wide_tables_and_what_stands_alone_between_them_span_both_columns(order: str, spans: str) -> None:
    parts: list[Part] = [TEXT if one == "t" else WIDE for one in order]
    assert "".join(f"{span:d}" for _, span in _spans(parts)) == spans
