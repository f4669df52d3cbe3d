"""Read the cells of a text file or a sheet: separators, decimal commas, numbers, words, and frame numbers."""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.door import LONGEST
from hypertuna.io.tables import parse_float, read_lines, split_line
from hypertuna.ranges import CELL
from hypertuna.trials.points import Rows

MISSING = frozenset({
    "", "nan", "na", "n/a", "n.a.", "none", "null", "(null)", "missing", "-", "--", "<na>", "-nan", "-nan(ind)", "#n/a",
    "#num!", "#value!", "#div/0!", "1.#qnan", "1.#ind", "-1.#ind",
})  # fmt: skip
WORDS = {"true": 1.0, "false": 0.0, "yes": 1.0, "no": 0.0, "visible": 1.0, "wahr": 1.0, "falsch": 0.0}  # of visibility
MARKS, FIRST_LINES = (";", "\t", ",", "|"), 30  # between cells, and lines in which they are sought
SPACES = ""  # the mark of cells between spaces
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
MAX_COMMENTS = 300
IMAGE = re.compile(r"(\d{1,12})(?:\.[A-Za-z]\w{0,4})?$", re.ASCII)  # number of a frame, last in its image's name


DATED = re.compile(r"(19|20)\d\d[-_]?\d\d[-_]?\d\d[-_T. ]\d\d[-_h.]?\d\d[-_m.]?\d\d[-_s.]\d", re.ASCII)
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
# Numbers as others write them, and what to do about each.
OTHER_NUMBERS = {
    re.compile(r"[+-]?\d{1,3}(?:[,.' \u2019\u202f\xa0]\d{3})+(?:[.,]\d+)?"): "without a separator of thousands",
    re.compile(r"[\u2212\u2013][\d.,]+(?:e\S+)?", re.IGNORECASE): "with a minus sign of ASCII, -",
    re.compile(r"[+-]?[\d.,]+d[+-]?\d+", re.IGNORECASE): "with e before the exponent, as 1.5e-3",
}
WITH_UNIT = re.compile(r"[+-]?[\d.,]+(?:e[+-]?\d+)? ?(?:[mcµu]?m|in|px|pixels?|[mµun]?s|deg|°|%)", re.IGNORECASE)
OTHER_NUMBERS[WITH_UNIT] = "without their unit, which belongs in the name of the column: nose_x_mm"
DAY, LATE = 86400.0, 82800.0  # s: a clock of the day that falls by more than the latter passes midnight
FRAMES_COUNTED = "a time code counts frames: write the number of each frame into a column frame"
CLOCK = re.compile(r"(?:(\d{1,4}):)?(\d{1,3}):(\d{1,2}(?:[.,]\d{1,12})?)", re.ASCII)  # hours, minutes, seconds
TIMECODE = re.compile(r"\d{1,3}:\d\d:\d\d[:;]\d{1,3}", re.ASCII)  # with the number of a frame in its second
HUNDREDTHS, IN_SECOND = re.compile(r"[\d:]*:\d\d[.,]\d\d", re.ASCII), 100  # or such a number; the former in a second


@dataclass(frozen=True)
class Grid:
    """The rows of a text file or a sheet, including lines of names, without empty lines and comments."""

    file: str
    rows: list[tuple[int, list[str]]]  # number of the line from 1, and cells
    comments: tuple[tuple[int, str], ...] = ()  # number of the line from 1, and text of each comment
    word: str = "line"  # of a row, in errors

    @property
    def comment(self) -> str:
        """The file's first comment."""
        return self.comments[0][1] if self.comments else ""

    def cells(self, row: int) -> list[str]:
        """Return the cells of a row in lower case; an empty list beyond the end."""
        return [cell.lower() for cell in self.rows[row][1]] if row < len(self.rows) else []

    def below(self, row: int, head: list[str]) -> "Samples":
        """Return the rows from `row` on as samples under the column names `head`; each row needs a cell per name.

        Empty cells behind them do not count: some programs end each row of numbers with a mark.
        """
        wide = len(head)
        rows = [(n, cells if any(cells[wide:]) else cells[:wide]) for n, cells in self.rows[row:]]
        for line, cells in rows:
            if len(cells) != len(head):
                rule, fix = f"must have {len(head)} cells, like the line of names", "complete the line or remove it"
                if len(cells) > 1.5 * len(head) and all(cell.lstrip("+-").isdecimal() for cell in cells):
                    fix = "are these decimal commas? Then save it with semicolons between the cells"
                raise InputError(rule, file=self.file, key=f"{self.word} {line}", value=f"{len(cells)} long", fix=fix)
        return Samples(self.file, head, rows, self.word)


@dataclass(frozen=True)
class Samples:
    """Rows with one cell per column name."""

    file: str
    head: list[str]
    rows: list[tuple[int, list[str]]]
    word: str = "line"  # of a row, in errors

    @property
    def where(self) -> Rows:
        """Names of the rows in errors, such as "line 12"."""
        return Rows(self.word, [line for line, _ in self.rows])

    def only(self, keep: Sequence[int]) -> "Samples":
        """Return only the rows with some indices."""
        return Samples(self.file, self.head, [self.rows[k] for k in keep], self.word)

    def text(self, column: int) -> list[str]:
        """Return the cells of a column, by its index."""
        return [row[column] for _, row in self.rows]

    def numbers(self, column: int, *, words: bool = False, infinite: bool = False, limit: bool = True) -> Array:
        """Return the numbers of a column, NaN for missing ones; a comma is a decimal sign in a column without points.

        words, infinite: whether cells with words of `WORDS` or infinite numbers may occur; limit: check for `CELL`.
        """
        values = np.fromiter(self._numbers(column, words, infinite, limit), float, len(self.rows))
        whole, size = values == np.round(values), np.abs(values)
        parts, large = size[~whole & np.isfinite(values)], size[whole & (size >= 100)]
        if len(parts) and len(large) and 10 * parts.max() < large.min():  # 998 beside 1,059
            for line, row in (row for row, part in zip(self.rows, ~whole, strict=True) if part):
                if THOUSANDS.fullmatch(row[column]):
                    fix = "write numbers without a separator of thousands"
                    raise self._error(line, column, "must be of the size of the others", shown(row[column]), fix)
        return values

    def _numbers(self, column: int, words: bool, infinite: bool, limit: bool) -> Iterator[float]:
        point_seen = comma_seen = False
        for line, row in self.rows:
            text = row[column]
            value = parse_float(text)
            if "." in text and not math.isnan(value):
                point_seen = True
            elif "," in text and DECIMAL_COMMA.fullmatch(text):
                value, comma_seen = parse_float(text.replace(",", ".")), True
            if point_seen and comma_seen:
                fix = "write all decimals with a point, and no separator of thousands"
                raise self._error(line, column, "must have one decimal sign", "a point above, and a comma here", fix)
            if value in CELL or (not limit and math.isfinite(value)):
                yield value
            elif text.lower() in MISSING or (infinite and math.isinf(value)):
                yield math.nan
            elif words and text.lower() in WORDS:
                yield WORDS[text.lower()]
            else:
                how = next((how for form, how in OTHER_NUMBERS.items() if form.fullmatch(text)), "")
                fix = f"write numbers {how}" if how else "give a number, or leave the cell empty"
                if text and text == self.head[column]:
                    fix = "the line of names comes again: give each run in a file of its own"
                if math.isfinite(value):
                    CELL.check(value, f"{self.word} {line}, {self.head[column]}", fix, file=self.file)
                raise self._error(line, column, "must be a number", shown(text), fix)

    def times(self, column: int) -> tuple[Array, bool]:
        """Return the times of a column, NaN for missing ones, and whether they are text: dates or clock times, in s."""
        if not any(":" in text for text in self.text(column)):
            return self.numbers(column, limit=False), False
        values = []
        for line, row in self.rows:
            value = math.nan if row[column].lower() in MISSING else clock_time(row[column])
            if value is None or math.isinf(value):
                rule, fix = "must be a time, such as 2026-05-04T12:30:15.250 or 12:30:15.250", "write seconds"
                if value is not None:
                    fix = f"{FRAMES_COUNTED}; before thousandths write a point"
                raise self._error(line, column, rule, shown(row[column]), fix)
            values.append(value)
        self._check_time_code(column)
        clocks = all(CLOCK.fullmatch(text) for text in self.text(column) if text.lower() not in MISSING)
        return _past_midnight(np.array(values)) if clocks else np.array(values), True

    def _check_time_code(self, column: int) -> None:
        """Check that the last two digits of clock times are hundredths, and no numbers of frames, which end before."""
        texts = [text for text in self.text(column) if text.lower() not in MISSING]
        if not all(HUNDREDTHS.fullmatch(text) for text in texts):
            return
        part = np.array([int(text[-2:]) for text in texts])
        step = np.diff(part)
        last = part[:-1][step < 0]
        if len(last) and (last + 2 * np.median(step[step >= 0]) < IN_SECOND).all():
            line, row = self.rows[int(np.flatnonzero(step < 0)[0])]
            rule = "must end with hundredths of a second, but these start over before 100"
            raise self._error(line, column, rule, shown(row[column]), FRAMES_COUNTED)

    def frames(self, column: int) -> Array:
        """Return the frame numbers of a column of numbers, or of image names with the number at the end."""
        values = []
        for line, row in self.rows:
            value = frame_number(row[column])
            if value is None:
                fix = "give the number of each frame, or the name of its image with the number at its end"
                raise self._error(line, column, "must be the number of a frame", shown(row[column]), fix)
            values.append(value)
        self._check_names(column, values)
        return np.array(values, dtype=float)

    def _check_names(self, column: int, values: list[float]) -> None:
        """Check that names of images end with the number of the frame, and not with a camera's or a clock's."""
        texts = self.text(column)
        if len(texts) < 3 or not math.isnan(parse_float(texts[0])) or texts[0].lower() in MISSING:
            return
        fix = "give a column frame, or the times in time_s"
        if len(set(values)) == 1 and len(set(texts)) > 1:
            rule = "must end with the number of the frame"
            raise InputError(rule, file=self.file, key=self.head[column], value=f"{values[0]:g} in all", fix=fix)
        if DATED.search(texts[0]) and np.median(np.diff(values)) != 1:
            rule, value = "must end with the number of the frame", f"{shown(texts[1])}"
            fix = f"these are names with a time of day: {fix}"
            raise InputError(rule, file=self.file, key=self.head[column], value=value, fix=fix)

    def _error(self, line: int, column: int, rule: str, value: str, fix: str) -> InputError:
        key = f"{self.word} {line}, {self.head[column]}"
        return InputError(rule, file=self.file, key=key, value=value, fix=fix)

    def check_once(self, columns: Sequence[int]) -> None:
        """Check that the name of each used column occurs only once."""
        names = [self.head[k] for k in columns]
        for name in names:
            if (count := names.count(name)) > 1:
                rule, value, fix = "must be there once", f"there {count} times", "rename or remove the others"
                raise InputError(rule, file=self.file, key=f"column {name}", value=value, fix=fix)


def _past_midnight(values: Array) -> Array:
    """Return the times of a clock of the day [s], NaN for missing ones, that go on after midnight.

    A clock that also leaps ahead by a day is not in order, and is left as it is.
    """
    known = np.isfinite(values)
    step = np.diff(values[known], prepend=values[known][:1])
    if not (step > LATE).any():
        values[known] += DAY * np.cumsum(step < -LATE)
    return values


def clock_time(text: str) -> float | None:
    """Return the seconds of a clock's time or of a date with it (ISO 8601); infinite for a time code, None if none."""
    if match := CLOCK.fullmatch(text):
        return 3600 * int(match[1] or 0) + 60 * int(match[2]) + float(match[3].replace(",", "."))
    if ":" not in text or TIMECODE.fullmatch(text):
        return math.inf if TIMECODE.fullmatch(text) else None
    try:
        moment = datetime.fromisoformat(text.replace(",", "."))
        return moment.replace(tzinfo=moment.tzinfo or UTC).timestamp()
    except (ValueError, OverflowError):
        return None


def frame_number(text: str) -> float | None:
    """Return the frame number in a text such as 12, 12.0, 1.2e+01 or img012.png; None if there is none."""
    value = parse_float(text)
    if math.isfinite(value) or text.lower() in MISSING:
        return value if math.isfinite(value) else math.nan
    match = IMAGE.search(text)
    return float(match[1]) if match else None


def read_grid(path: str | Path) -> Grid:
    """Read the cells of a text file; commas, semicolons, tabs, bars or spaces separate them."""
    file = str(path)
    content: list[tuple[int, str]] = []
    comments: list[tuple[int, str]] = []
    for number, line in enumerate(read_lines(path), 1):
        if line.lstrip().startswith("#"):
            comments += [(number, line.strip())] * (len(comments) < MAX_COMMENTS)
        elif line.strip():
            if len(line) > LONGEST:
                rule, fix = f"must have at most {LONGEST} characters", "give one sample a line"
                raise InputError(rule, file=file, key=f"line {number}", value="longer", fix=fix)
            content.append((number, line))
    if len(content) < 2:
        fix = "give a line of column names, then one line per frame"
        raise InputError("must be a table", file=file, value="empty", fix=fix)
    excel_mark = re.fullmatch(r'"?sep=(.)"?', content[0][1].strip(), re.IGNORECASE)  # first line in files of Excel
    content = content[1:] if excel_mark else content
    mark = excel_mark[1] if excel_mark else _mark(file, [line for _, line in content])
    rows = [(n, _split(line, file, n, mark)) for n, line in content]
    above = next(((n, text) for n, text in reversed(comments) if n < rows[0][0]), None)
    if above and is_number(*rows[0][1]):
        names = _split(above[1].lstrip("# "), file, above[0], mark)
        if len(names) == len(rows[0][1]) and not any(map(is_number, names)):
            rows.insert(0, (above[0], names))
    while len(rows) > 2 and not any(rows[-1][1]):  # as Excel leaves them
        rows.pop()
    return Grid(file, rows, tuple(comments))


def _mark(file: str, lines: Sequence[str]) -> str:
    """Return the mark between the cells of lines; `SPACES` where all lines have as many words."""
    first = next((line for line in lines[:FIRST_LINES] if any(mark in line for mark in MARKS)), lines[0])
    counts: Callable[[str], int] = first.count
    mark = max(MARKS, key=counts)
    if counts(mark) and mark != ",":
        return mark
    words = [word for line in lines[:FIRST_LINES] for word in line.split()]
    if all(DECIMAL_COMMA.fullmatch(word) or "," not in word for word in words) and len(lines[0].split()) > 2:
        if len({len(line.split()) for line in lines}) == 1:
            return SPACES
        if not counts(mark):
            fix = "write as many cells in each line, with commas, semicolons or tabs between them"
            raise InputError("must be a table of cells", file=file, value="separated by spaces", fix=fix)
    return mark


def _split(line: str, file: str, number: int, mark: str) -> list[str]:
    """Split a line of a table."""
    return line.split() if mark == SPACES else split_line(line, file, number, mark)


def is_number(*texts: str) -> bool:
    """Return whether all texts are numbers."""
    return all(not math.isnan(parse_float(text.replace(",", "."))) for text in texts)
