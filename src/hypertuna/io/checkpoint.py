"""Journal: an append-only record of questions and answers, from which long work resumes after any interruption.

Work that resumes is deterministic: it asks the same questions in the same order, and the journal answers those that it
knows. So the result after a kill is the same by construction; no other state is kept. Each line ends in a checksum of
itself and all lines before it: a changed, missing or exchanged line is found when the journal is opened.
"""

import codecs
import contextlib
import fcntl
import io
import json
import os
import re
import warnings
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hypertuna.errors import DamageWarning, InputError, shown
from hypertuna.io.door import check_memory, check_regular, parse_json, read_bytes
from hypertuna.io.files import Closing, unwritable

MARK = "hypertuna journal"  # in the header of every journal
# Fix of errors about a file of another run or with damage
ANOTHER = "give another file, or remove this one to start over"
SUM = re.compile(rb', "crc32": "([0-9a-f]{8})"}\n')  # checksum at the end of a line


def read_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a journal."""
    return _header(str(path), _first_line(read_bytes(path, "journal")))[0]


class Journal(Closing):
    """A file of JSON lines: the header, then one record per question with its answer.

    Each record is on the disk before work continues. A torn last line is dropped; a damaged line is dropped with all
    after it and a warning, or an error if the answers are `measured`, not computed. One process at a time may hold a
    journal. Without a path nothing is kept.

    Examples
    --------
    >>> with Journal(None, {}) as journal:
    ...     journal.answer([1.0, 2.0], lambda: [3.0])
    [3.0]
    """

    def __init__(self, path: str | Path | None, header: Mapping[str, Any], *, measured: bool = False) -> None:
        self.records: list[dict[str, Any]] = []
        self._next = 0  # first record whose question this run has not asked
        self._sum = 0  # checksum of all lines
        self._file: io.FileIO | None = None
        self._path = Path() if path is None else Path(path)
        if path is None:
            return
        try:
            # Created by opening and started under the lock: of two simultaneous runs one is refused.
            self._file = io.FileIO(self._path, "r+", opener=_open_or_create)
            check_regular(self._file.fileno(), str(path), "journal")
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            fix = "wait until that run ends, or give another file"
            raise InputError("is in use by another run", file=str(path), fix=fix) from None
        except OSError as error:
            raise unwritable(path, error) from None
        except InputError:
            self.close()
            raise
        try:
            self.records = self._resume(self._file, header, measured)
        except BaseException:
            self.close()
            raise

    @property
    def unread(self) -> int:
        """Number of stored records that no question of this run has read yet."""
        return len(self.records) - self._next

    def answer(self, asked: Any, work: Callable[[], Any]) -> Any:
        """Return the answer to the next question: from the journal, else computed by `work` and appended.

        Question and answer are numbers, texts, arrays, or lists and mappings of them; arrays return as lists.
        """
        if self._file is None:
            return json.loads(_json_line({"told": work()}))["told"]
        if self._next < len(self.records):
            record = self.records[self._next]
            if "told" not in record or record.get("asked") != json.loads(_json_line({"asked": asked}))["asked"]:
                rule = "belongs to a different run: its entries do not match those of this one"
                raise InputError(rule, file=self._place(self._next), fix=ANOTHER)
        else:
            record = self.append({"asked": asked, "told": work()})
        self._next += 1
        return record["told"]

    def append(self, record: Mapping[str, Any]) -> dict[str, Any]:
        """Append a record to the file and return it, arrays as lists."""
        line = _json_line(record)
        if self._file is not None:
            self._write(self._file, line)
        self.records.append(json.loads(line))
        return self.records[-1]

    def close(self) -> None:
        """Close and unlock the file."""
        if self._file is not None:
            self._file.close()

    def _resume(self, file: io.FileIO, header: Mapping[str, Any], measured: bool) -> list[dict[str, Any]]:
        """Check the header and read the records; drop the torn or damaged end of the file."""
        content, header_line = file.readall() or b"", _json_line({"journal": MARK} | dict(header))
        first = _with_checksum(header_line, 0)[0]
        if content != first and first.startswith(content):  # empty, or a torn header
            file.seek(0)
            self._write(file, header_line)
            content = first
        line = _first_line(content)
        stored, self._sum = _header(str(self._path), line)
        check_same_header(str(self._path), stored, header, ANOTHER)
        try:
            check_memory(content)
        except ValueError as error:
            raise InputError(f"has {error}", file=str(self._path), fix=ANOTHER) from None
        records: list[dict[str, Any]] = []
        stream, intact = io.BytesIO(content), len(line)
        stream.seek(intact)
        while line := stream.readline():
            missing = b"" if line.endswith(b"\n") else b"\n"  # of a torn line, or of one that an editor took
            record, checksum = _checked_record(line + missing, self._sum)
            if record is None:
                if not missing:
                    self._report_damage(len(records), content.count(b"\n", intact) - 1, measured)
                break
            records.append(record)
            self._sum, intact = checksum, intact + len(line)
            if missing:
                file.seek(0, os.SEEK_END)
                file.write(missing)
        if intact < len(content):
            file.truncate(intact)
        file.seek(0, os.SEEK_END)
        return records

    def _report_damage(self, record: int, after: int, measured: bool) -> None:
        """Warn of a damaged line, or refuse it where the answers cannot be computed again."""
        if measured:
            rule, fix = "is damaged", "remove this line and all after it, and enter their measurements again"
            raise InputError(rule, file=self._place(record), fix=fix)
        lines = "this line is" if not after else f"this line and the {after} after it are"
        warnings.warn(f"{self._place(record)} is damaged: {lines} computed again.", DamageWarning, stacklevel=2)

    def _write(self, file: io.FileIO, line: bytes) -> None:
        """Write a line with its checksum to the disk, whole or not at all; an empty file is removed."""
        content, checksum = _with_checksum(line, self._sum)
        start, unwritten = file.tell(), memoryview(content)
        try:
            while unwritten:
                unwritten = unwritten[file.write(unwritten) :]
            os.fsync(file.fileno())
        except OSError as error:
            with contextlib.suppress(OSError):
                file.truncate(start)
                if not start:
                    self._path.unlink()
            raise unwritable(self._path, error) from None
        self._sum = checksum

    def _place(self, record: int) -> str:
        """Return file and line, from 1, of a record."""
        return f"{self._path}:{record + 2}"


def _open_or_create(file: str, how: int) -> int:
    """Open a journal, created where there is none, without waiting for the other end of a pipe."""
    return os.open(file, how | os.O_CREAT | os.O_NONBLOCK, 0o666)


def check_same_header(file: str, stored: Mapping[str, Any], header: Mapping[str, Any], fix: str) -> None:
    """Check that the header stored in a file is that of the present work."""
    old, new = _flat(json.loads(_json_line(stored))), _flat(json.loads(_json_line(header)))
    for key in {**old, **new}:
        if old.get(key) != new.get(key):
            key, *pair = _difference(key, old.get(key), new.get(key))
            rule = f"was started with {key} = {shown(pair[0])}, but now it is {shown(pair[1])}"
            raise InputError(rule, file=file, fix=fix)


def _difference(key: str, old: Any, new: Any) -> tuple[str, Any, Any]:
    """Return the dotted key of the first difference in two values, and what they have there."""
    while isinstance(old, dict) and isinstance(new, dict):
        part = next(part for part in {**old, **new} if old.get(part) != new.get(part))
        key, old, new = f"{key}.{part}", old.get(part), new.get(part)
    return key, old, new


def _json_line(value: Mapping[str, Any]) -> bytes:
    """Return a record as JSON; NaN and Infinity are kept, so that all numbers survive."""
    return json.dumps(value, default=lambda array: array.tolist(), ensure_ascii=False).encode()


def _with_checksum(line: bytes, before: int) -> tuple[bytes, int]:
    """Return a line with its checksum, and the checksum; `before` is the checksum of all earlier lines."""
    checksum = zlib.crc32(line, before)
    return line[:-1] + b', "crc32": "%08x"}\n' % checksum, checksum


def _checked_record(line: bytes, before: int) -> tuple[dict[str, Any] | None, int]:
    """Return a line's record, or None if its checksum is wrong, and the checksum; before: that of earlier lines."""
    match = SUM.search(line)
    body = line[: match.start()] + b"}" if match is not None and match.end() == len(line) else b""
    checksum = zlib.crc32(body, before)
    if match is None or not body or int(match[1], 16) != checksum:
        return None, before
    try:
        record = parse_json(body)
    except ValueError:
        record = None
    return (record, checksum) if isinstance(record, dict) else (None, before)


def _first_line(content: bytes) -> bytes:
    """Return the first whole line."""
    return content[: content.find(b"\n") + 1]


def _header(file: str, line: bytes) -> tuple[dict[str, Any], int]:
    """Return the header of the first line, and its checksum."""
    try:
        header = parse_json(line) if line else None
    except ValueError:
        header = None
    if not isinstance(header, dict) or header.get("journal") != MARK or not isinstance(header.get("options", {}), dict):
        raise InputError("must be a journal of hypertuna", file=file, fix="give another file")
    if "crc32" not in header:
        raise InputError("must be a journal with checksums, which earlier versions lack", file=file, fix=ANOTHER)
    checked, checksum = _checked_record(line, 0)
    if checked is None and (line.endswith(b"\r\n") or line.startswith(codecs.BOM_UTF8)):
        rule, fix = "was saved by an editor with other line ends, or a mark at its begin", "undo it, as dos2unix does"
        raise InputError(rule, file=file, fix=fix)
    if checked is None:
        raise InputError("is damaged", file=f"{file}:1", fix=ANOTHER)
    del checked["journal"]
    return checked, checksum


def _flat(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return a header with its options at the top level."""
    return {**{key: value for key, value in header.items() if key != "options"}, **header.get("options", {})}
