"""Journal: an append-only record of questions and answers, from which long work resumes after any interruption.

Work that resumes is deterministic: it asks the same questions in the same order, and the journal answers those that it
knows. So the result after a kill is the same by construction; no other state is kept.
"""

import fcntl
import io
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self

from hypertuna.errors import InputError, shown
from hypertuna.io.files import read_bytes, unwritable

MARK = "hypertuna journal"
ANOTHER = "give another file, or remove this one to start over"


def read_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a journal."""
    return _header(Path(path), read_bytes(path).splitlines(keepends=True))


class Journal:
    """A file of JSON lines: the header, then one record per question with its answer.

    Each record is on the disk before work continues. A torn last line is dropped. One process at a time may hold a
    journal. Without a path nothing is kept.

    Examples
    --------
    >>> with Journal(None, {}) as journal:
    ...     journal.answer([1.0, 2.0], lambda: [3.0])
    [3.0]
    """

    def __init__(self, path: str | Path | None, header: Mapping[str, Any]) -> None:
        self.records: list[dict[str, Any]] = []
        self._next = 0  # first record whose question this run has not asked
        self._file: io.FileIO | None = None
        self._path = Path() if path is None else Path(path)
        if path is None:
            return
        try:
            # Created by opening and started under the lock: of two simultaneous runs one is refused.
            self._file = io.FileIO(self._path, "r+", opener=lambda file, how: os.open(file, how | os.O_CREAT, 0o666))
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            fix = "wait until that run ends, or give another file"
            raise InputError("is in use by another run", file=str(path), fix=fix) from None
        except OSError as error:
            raise unwritable(path, error) from None
        try:
            self.records = self._resume(self._file, header)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def known(self) -> int:
        """Number of records whose questions this run has not asked yet."""
        return len(self.records) - self._next

    def answer(self, asked: Any, work: Callable[[], Any]) -> Any:
        """Return the answer to the next question: from the journal, else computed by `work` and appended.

        Both are numbers, texts, arrays, lists and mappings of them; arrays return as lists.
        """
        if self._file is None:
            return json.loads(_line({"told": work()}))["told"]
        if self._next < len(self.records):
            record = self.records[self._next]
            if "told" not in record or record.get("asked") != json.loads(_line({"asked": asked}))["asked"]:
                rule = "belongs to a different run: its entries do not match those of this one"
                raise InputError(rule, file=self._place(self._next), fix=ANOTHER)
        else:
            record = self.append({"asked": asked, "told": work()})
        self._next += 1
        return record["told"]

    def append(self, record: Mapping[str, Any]) -> dict[str, Any]:
        """Append a record to the file and return it, arrays as lists."""
        line = _line(record)
        if self._file is not None:
            _write(self._file, line)
        self.records.append(json.loads(line))
        return self.records[-1]

    def close(self) -> None:
        """Close and unlock the file."""
        if self._file is not None:
            self._file.close()

    def _resume(self, file: io.FileIO, header: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Check the header and read the records; drop the torn end of the file."""
        content, first = file.readall(), _line({"journal": MARK} | dict(header))
        if content != first and first.startswith(content):  # empty, or a torn header
            file.seek(0)
            _write(file, first)
            content = first
        whole = content[: content.rfind(b"\n") + 1]
        lines = whole.splitlines(keepends=True)
        old, new = _flat(_header(self._path, lines)), _flat(json.loads(_line(header)))
        for key in {**old, **new}:
            if old.get(key) != new.get(key):
                rule = f"was started with {key} = {shown(old.get(key))}, but now it is {shown(new.get(key))}"
                raise InputError(rule, file=str(self._path), fix=ANOTHER)
        records = [_record(line, self._place(k)) for k, line in enumerate(lines[1:])]
        if len(whole) < len(content):
            file.truncate(len(whole))
        file.seek(0, os.SEEK_END)
        return records

    def _place(self, record: int) -> str:
        """File and line, from 1, of a record."""
        return f"{self._path}:{record + 2}"


def _line(value: Mapping[str, Any]) -> bytes:
    """Return a record as a line of JSON; NaN and Infinity are kept, so that all numbers survive."""
    return json.dumps(value, default=lambda array: array.tolist(), ensure_ascii=False).encode() + b"\n"


def _write(file: io.FileIO, line: bytes) -> None:
    """Write a whole line to the disk."""
    rest = memoryview(line)
    while rest:
        rest = rest[file.write(rest) :]
    os.fsync(file.fileno())


def _parsed(line: bytes) -> dict[str, Any] | None:
    """Parse a line; None if it is no JSON object."""
    try:
        record = json.loads(line)
    except ValueError:
        return None
    return record if isinstance(record, dict) else None


def _record(line: bytes, place: str) -> dict[str, Any]:
    """Return the record of a line."""
    if (record := _parsed(line)) is None:
        raise InputError("must be a line of a journal", file=place, value=shown(line[:40].decode(errors="replace")))
    return record


def _header(path: Path, lines: list[bytes]) -> dict[str, Any]:
    """Return the header of the first line."""
    header = _parsed(lines[0]) if lines else None
    if header is None or header.pop("journal", None) != MARK or not isinstance(header.get("options", {}), dict):
        raise InputError("must be a journal of hypertuna", file=str(path), fix="give another file")
    return header


def _flat(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return a header with its options at the top level."""
    return {**{key: value for key, value in header.items() if key != "options"}, **header.get("options", {})}
