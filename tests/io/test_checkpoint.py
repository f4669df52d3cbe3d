"""The journal: its records are read back after any end of the run."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from disk import full_disk
from hypertuna.description.provenance import journal_header
from hypertuna.errors import DamageWarning, InputError
from hypertuna.io.checkpoint import Journal, read_header

HEADER = {"kind": "test", "version": "1", "options": {"seed": 1, "bounds": [0.0, 0.1]}}


def summed(journal: Journal, questions: int) -> tuple[list[float], int]:
    """Ask question after question, each from the last answer; return the answers and how many were worked out."""
    sums, worked = [0.1], []
    for _ in range(questions):
        told = journal.answer([sums[-1]], lambda: worked.append(1) or [sums[-1] ** 2 + 0.1])  # type: ignore[func-returns-value]
        sums.append(told[0])
    return sums, len(worked)


@pytest.mark.parametrize("kept", range(6))
def test_resumed_work_ends_like_work_that_never_stopped(tmp_path: Path, kept: int) -> None:
    with Journal(None, {}) as journal:
        through, worked = summed(journal, 5)
    assert worked == 5
    with Journal(tmp_path / "run.jsonl", HEADER) as journal:
        summed(journal, kept)
    with Journal(tmp_path / "run.jsonl", HEADER) as journal:
        assert journal.unread == kept
        assert summed(journal, 5) == (through, 5 - kept)
        assert journal.unread == 0


def test_torn_last_line_is_dropped_at_every_length(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        through, _ = summed(journal, 3)
    whole = path.read_bytes()
    first = len(whole.splitlines(keepends=True)[0])
    for length in range(first, len(whole), 7):
        path.write_bytes(whole[:length])
        with Journal(path, HEADER) as journal:
            assert summed(journal, 3)[0] == through
        assert path.read_bytes() == whole


def test_a_whole_line_whose_end_an_editor_took_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        summed(journal, 3)
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    with Journal(path, HEADER) as journal:
        assert journal.unread == 3
        assert path.read_bytes() == whole
        summed(journal, 4)
    with Journal(path, HEADER) as journal:
        assert journal.unread == 4


def test_every_number_comes_back_as_it_was(tmp_path: Path) -> None:
    told = {"x": np.array([0.1, math.pi, 5e-324, 1e308, -0.0]), "status": np.int8(3), "bad": [math.nan, math.inf]}
    with Journal(tmp_path / "run.jsonl", HEADER) as journal:
        first = journal.answer("q", lambda: told)
    with Journal(tmp_path / "run.jsonl", HEADER) as journal:
        again = journal.answer("q", lambda: pytest.fail("the journal knows this"))
    assert first["x"] == again["x"] == told["x"].tolist()  # type: ignore[union-attr]
    assert math.copysign(1, again["x"][-1]) == -1
    assert again["status"] == 3
    assert math.isnan(again["bad"][0])
    assert again["bad"][1] == math.inf


@pytest.mark.parametrize(
    ("header", "word"),
    [
        (HEADER | {"version": "2"}, "version = '1', but now it is '2'"),
        (HEADER | {"options": {"seed": 2, "bounds": [0.0, 0.1]}}, "seed = 1, but now it is 2"),
        (HEADER | {"options": {"seed": 1, "bounds": [0.0, 0.1], "new": True}}, "new = None, but now it is true"),
        (HEADER | {"options": {"seed": 1}}, "bounds"),
    ],
)
def test_other_work_is_refused_by_the_option_that_differs(tmp_path: Path, header: dict[str, Any], word: str) -> None:
    Journal(tmp_path / "run.jsonl", HEADER).close()
    with pytest.raises(InputError, match=word):
        Journal(tmp_path / "run.jsonl", header)


def test_a_file_that_is_no_journal_is_left_alone(tmp_path: Path) -> None:
    number = json.dumps({"journal": "hypertuna journal", "kind": "test", "options": 3}).encode() + b"\n"
    for content in (b"precious", b"precious\n", b'{"a": 1}\n', b"[1]\n", b"\xff\xfe\n", number):
        path = tmp_path / "file"
        path.write_bytes(content)
        with pytest.raises(InputError, match="must be a journal"):
            Journal(path, HEADER)
        assert path.read_bytes() == content


def test_damage_is_told_and_computed_again(tmp_path: Path) -> None:
    """Each changed byte of a record is found: a sentence with file and line, and the same result and file again."""
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        through, _ = summed(journal, 3)
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    for place in range(len(lines[0]), len(whole) - 1, 3):
        line = whole[:place].count(b"\n") + 1
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.warns(DamageWarning, match=rf"run.jsonl:{line} is damaged: this line") as told:
            journal = Journal(path, HEADER)
        assert len(told) == 1
        assert journal.unread == line - 2
        assert summed(journal, 3)[0] == through
        journal.close()
        assert path.read_bytes() == whole


@pytest.mark.parametrize(
    ("damaged", "words"),
    [(1, "this line and the 2 after it are"), (2, "this line and the 1 after it are"), (3, "this line is")],
)
def test_damage_counts_the_lines_that_it_costs(tmp_path: Path, damaged: int, words: str) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        summed(journal, 3)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[damaged] = lines[damaged].replace(b"told", b"Told")
    path.write_bytes(b"".join(lines))
    with pytest.warns(DamageWarning, match=words), Journal(path, HEADER) as journal:
        assert journal.unread == damaged - 1


def test_lines_that_are_missing_or_exchanged_are_damage(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        for number in range(3):  # the same question: only the answers differ
            journal.answer("q", lambda number=number: number)  # type: ignore[misc]
    head, *records = path.read_bytes().splitlines(keepends=True)
    for order, kept in (((1, 2), 0), ((1, 0, 2), 0), ((0, 2), 1), ((0, 0, 1, 2), 1), ((0, 1, 1), 2)):
        path.write_bytes(head + b"".join(records[k] for k in order))
        with pytest.warns(DamageWarning, match=f"run.jsonl:{kept + 2} is damaged"), Journal(path, HEADER) as journal:
            assert [record["told"] for record in journal.records] == list(range(kept))


def test_damaged_measurements_are_refused_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER, measured=True) as journal:
        summed(journal, 3)
    content = path.read_bytes().replace(b'"told"', b'"tolb"', 2)
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"run.jsonl:2 is damaged: remove this line and all after it"):
        Journal(path, HEADER, measured=True)
    assert path.read_bytes() == content


def test_a_damaged_header_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    Journal(path, HEADER).close()
    whole = path.read_bytes()
    for content, word in (
        (whole.replace(b'"seed": 1', b'"seed": 2'), "run.jsonl:1 is damaged"),
        (whole.replace(b"\n", b"\r\n"), "run.jsonl was saved by an editor with other line ends"),
        (b"\xef\xbb\xbf" + whole, "run.jsonl was saved by an editor with other line ends, or a mark at its begin"),
        (json.dumps({"journal": "hypertuna journal", **HEADER}).encode() + b"\n", "must be a journal with checksums"),
    ):
        path.write_bytes(content)
        for opened in (lambda: Journal(path, HEADER), lambda: read_header(path)):
            with pytest.raises(InputError, match=word):
                opened()


def test_a_full_disk_is_named_and_leaves_whole_lines(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk: the last record is missing as a whole, and work resumes."""
    path, new = tmp_path / "run.jsonl", tmp_path / "new.jsonl"
    with Journal(path, HEADER) as journal:
        through, _ = summed(journal, 3)
    whole = path.read_bytes()
    second = len(b"".join(whole.splitlines(keepends=True)[:2]))
    path.unlink()
    with (
        full_disk(second + 20),
        Journal(path, HEADER) as journal,
        pytest.raises(InputError, match=r"run.jsonl must be a writable file"),
    ):
        summed(journal, 3)
    with full_disk(20), pytest.raises(InputError, match=r"new.jsonl must be a writable file, but is not \(File too"):
        Journal(new, HEADER)
    assert not new.exists()
    assert path.read_bytes() == whole[:second]
    with Journal(path, HEADER) as journal:
        assert summed(journal, 3) == (through, 2)


def test_another_course_is_no_answer(tmp_path: Path) -> None:
    with Journal(tmp_path / "run.jsonl", HEADER) as journal:
        journal.answer([1.0], lambda: [2.0])
    with (
        Journal(tmp_path / "run.jsonl", HEADER) as journal,
        pytest.raises(InputError, match=r"run.jsonl:2 belongs to a different run"),
    ):
        journal.answer([1.5], lambda: [2.0])


def test_a_record_without_an_answer_is_no_record(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        journal.append({"asked": [1.0]})
    with Journal(path, HEADER) as journal, pytest.raises(InputError, match=r"run.jsonl:2 belongs to a different run"):
        journal.answer([1.0], lambda: [2.0])


def test_a_header_torn_at_any_length_is_begun_again(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    Journal(path, HEADER).close()
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        with Journal(path, HEADER) as journal:
            assert journal.unread == 0
        assert path.read_bytes() == whole


def test_of_two_runs_that_begin_at_once_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.jsonl"
    with Journal(path, HEADER) as journal:
        journal.answer([1.0], lambda: [2.0])
        before = path.read_bytes()
        monkeypatch.setattr(Path, "exists", lambda _: False)  # as the other saw it before
        with pytest.raises(InputError, match="in use by another run"):
            Journal(path, HEADER)
        assert path.read_bytes() == before


def test_one_run_at_a_time(tmp_path: Path) -> None:
    with (
        Journal(tmp_path / "run.jsonl", HEADER),
        pytest.raises(InputError, match="in use by another run"),
    ):
        Journal(tmp_path / "run.jsonl", HEADER)
    Journal(tmp_path / "run.jsonl", HEADER).close()


def test_places_that_cannot_be_written_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be a writable file"):
        Journal(tmp_path, HEADER)
    with pytest.raises(InputError, match="must be a file, but is missing"):
        read_header(tmp_path / "none.jsonl")


def test_header_says_what_the_work_is(tmp_path: Path, tuna: ht.Robot) -> None:
    header = journal_header("optimize", tuna, {"seed": 1})
    Journal(tmp_path / "run.jsonl", header).close()
    assert read_header(tmp_path / "run.jsonl") == json.loads(json.dumps(header))
    assert header["robot_hash"] == tuna.hash
    other = journal_header("optimize", tuna.using(joints="ideal"), {"seed": 1})
    with pytest.raises(InputError, match="robot_hash"):
        Journal(tmp_path / "run.jsonl", other)


def test_the_first_difference_of_an_option_is_named(tmp_path: Path) -> None:
    robots = [{"name": "minnow", "body": {"mass_kg": mass, "length_m": 0.3}} for mass in (1.0, 2.0)]
    headers = [{"kind": "test", "version": "1", "options": {"robot": robot}} for robot in robots]
    Journal(tmp_path / "run.jsonl", headers[0]).close()
    with pytest.raises(InputError, match="was started with robot.body.mass_kg = 1.0, but now it is 2.0"):
        Journal(tmp_path / "run.jsonl", headers[1])
