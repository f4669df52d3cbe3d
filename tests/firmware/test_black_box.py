"""Black box: what the firmware wrote comes back bit by bit, and damage costs no more than the records that it hits."""

import json
import struct
import time
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from black_box import JOINTS, head, sealed, tick
from hypertuna import _core
from hypertuna.errors import InputError
from hypertuna.firmware.black_box import Box, mission_record, read_black_box, record_dtype
from hypertuna.firmware.boards import find_firmware, missing
from hypertuna.firmware.in_the_loop import firmware_in_the_loop
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.scenario import find_scenario
from hypertuna.mission.record import COLUMNS, parts_of
from program import Run


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna")


def read(path: Path, content: bytes) -> list[Box]:
    path.write_bytes(content)
    return read_black_box(path)


def told(box: Box) -> tuple[list[int], int, int, int, int]:
    return box.ticks["tick"].tolist(), box.missing, box.damaged, box.skipped, box.cut


# --- the format


def test_the_record_is_what_logs_have_names_for() -> None:
    """Every word of the firmware's list is a quantity of a record, with as many parts."""
    dtype = record_dtype(JOINTS)
    joints, circuits = ("I", "II"), ("a", "b", "c", "d")
    for name in set(dtype.names or ()) - {"tick"}:
        parts = parts_of(name, joints, circuits)
        assert dtype[name].shape == ((len(parts),) if parts else ()), name
    assert dtype.itemsize == 4 * 52
    assert len(tick(0)) == 216
    assert record_dtype(4).itemsize > dtype.itemsize


def test_a_whole_box(tmp_path: Path) -> None:
    (box,) = read(tmp_path / "box.bin", head() + b"".join(tick(k) for k in range(5, 10_005)))
    assert told(box) == ([*range(5, 10_005)], 0, 0, 0, 0)
    assert not box.gaps
    assert "no tick is missing" in box.sentence
    assert box.ticks["mode"].tolist()[:4] == [2, 0, 1, 2]


def test_damage_costs_what_it_hits(tmp_path: Path) -> None:
    """A flipped bit, bytes lost, bytes from elsewhere, a power cut: the other records are all there."""
    file, ticks = tmp_path / "box.bin", [tick(k) for k in range(10)]
    flipped = bytearray(ticks[3])
    flipped[40] ^= 4
    content = head() + b"".join([*ticks[:3], bytes(flipped), *ticks[4:]])
    assert told(read(file, content)[0]) == ([0, 1, 2, 4, 5, 6, 7, 8, 9], 1, 1, 216, 0)
    content = head() + b"".join([*ticks[:5], ticks[5][:101], *ticks[6:]])
    assert told(read(file, content)[0]) == ([0, 1, 2, 3, 4, 6, 7, 8, 9], 1, 1, 101, 0)
    content = head() + b"".join([*ticks[:5], b"\x0c\xb1 noise \x0c\xb1", *ticks[5:]])
    assert told(read(file, content)[0]) == ([*range(10)], 0, 1, 11, 0)
    content = head() + b"".join(ticks)
    for cut in range(1, 216):
        assert told(read(file, content[:-cut])[0]) == ([*range(9)], 0, 0, 0, 216 - cut)
    for place in range(len(head()), len(content), 7):  # any one byte changed costs its record alone
        damaged = bytearray(content)
        damaged[place] ^= 0xFF
        (box,) = read(file, bytes(damaged))
        lost = (place - len(head())) // 216
        assert box.ticks["tick"].tolist() == [k for k in range(10) if k != lost]
        assert box.damaged + bool(box.cut) == 1


@pytest.mark.parametrize("blank", [b"\0", b"\xff"])
def test_sectors_that_were_laid_out_and_not_written_are_none(tmp_path: Path, blank: bytes) -> None:
    """The board lays out its file before; where the power goes, all after the last sector is as it was erased."""
    content = head() + b"".join(tick(k) for k in range(1000))
    written = content[: len(content) // 512 * 512]
    whole = (len(written) - len(head())) // 216
    (box,) = read(tmp_path / "box.bin", written + blank * 2**20)
    assert told(box) == ([*range(whole)], 0, 0, 0, len(written) - len(head()) - 216 * whole)


def test_boots_are_told_apart(tmp_path: Path) -> None:
    first, second = read(tmp_path / "box.bin", head() + tick(0) + tick(1) + head() + tick(0) + tick(3))
    assert told(first) == ([0, 1], 0, 0, 0, 0)
    assert told(second) == ([0, 3], 2, 0, 0, 0)
    assert second.sentence == "The box has gaps: 2 of 4 ticks are missing."


def test_a_damaged_first_record_costs_itself_alone(tmp_path: Path, fish: ht.Robot) -> None:
    """Of either boot: the number of joints follows from the size of the ticks, a boot from its clock."""
    one, two = [tick(k) for k in range(5)], [tick(k) for k in range(4)]
    bad = head()[:9] + b"\xff" + head()[10:]
    (first, second) = read(tmp_path / "box.bin", b"".join([bad, *one, bad, *two]))
    assert (first.layout, second.layout) == (None, None)
    assert (first.ticks["tick"].tolist(), second.ticks["tick"].tolist()) == ([*range(5)], [*range(4)])
    assert (first.joints, first.damaged, first.skipped) == (JOINTS, 2, 2 * len(head()))
    facts = mission_record(second, fish).facts
    assert facts["parameters"] == "unknown: the first record of the boot is damaged"


@pytest.mark.parametrize("number", [float("nan"), float("inf"), 1e38])
def test_impossible_numbers_cost_their_record(tmp_path: Path, number: float) -> None:
    """Of all fields in turn; readings may be NaN, where a sensor is silent."""
    kinds = record_dtype(JOINTS)
    names = [name for name in kinds.names or () if kinds[name].base.kind == "f"]
    for name in names:
        row = np.frombuffer(tick(1)[4:-4], record_dtype(JOINTS)).copy()
        row[name] = number
        content = head() + tick(0) + sealed(_core.RECORD_TICK, row.tobytes()) + tick(2)
        (box,) = read(tmp_path / "box.bin", content)
        silent = np.isnan(number) and COLUMNS[name].silent
        assert told(box) == (([0, 1, 2], 0, 0, 0, 0) if silent else ([0, 2], 1, 1, 208, 0)), name


def test_ticks_out_of_order_are_damage(tmp_path: Path) -> None:
    for order, kept in (((0, 1, 9, 2, 3), [0, 1, 2, 3]), ((0, 1, 1, 2), [0, 1, 2]), ((5, 6, 1, 7), [5, 6, 7])):
        (box,) = read(tmp_path / "box.bin", head() + b"".join(map(tick, order)))
        assert (box.ticks["tick"].tolist(), box.damaged) == (kept, 1)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "must be a black box"),
        (b"nothing of the kind" * 100, "must be a black box"),
        (sealed(_core.RECORD_TICK, bytes(40)), "must be a black box: it has no header"),
        (head(joints=10**9) + tick(0), f"must be of 1 to {_core.BOARD_JOINTS} joints, but is of 1000000000"),
        (head(), "must have complete records"),
        (head(layout=0x1234) + tick(0), rf"must have the layout {_core.RECORD_LAYOUT:08x}, but is 00001234"),
    ],
)
def test_what_is_no_box_is_told(tmp_path: Path, content: bytes, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read(tmp_path / "box.bin", content)
    with pytest.raises(InputError, match="must be a file, but is missing"):
        read_black_box(tmp_path / "none.bin")


@pytest.mark.parametrize("count", [1, 255])
def test_marks_without_records_are_given_up(tmp_path: Path, count: int) -> None:
    """Each word was taken for the first of 4,096 records: minutes for a megabyte."""
    mark = struct.pack("<I", _core.RECORD_MARK | _core.RECORD_TICK << 8 | count)
    begin = time.process_time()
    with pytest.raises(InputError, match="box.bin must be a black box: it is damaged in more than 30000 places"):
        read(tmp_path / "box.bin", head() + tick(0) + mark * 300_000)
    with pytest.raises(InputError, match="damaged in more than 30000 places"):
        read(tmp_path / "box.bin", head() + (tick(0) + sealed(9, b"")) * 20_000)
    with pytest.raises(InputError, match="must have at most 1000 boots, but is 1500"):
        read(tmp_path / "box.bin", head() + b"".join(map(tick, range(3))) * 1500)
    assert time.process_time() - begin < 15


def test_a_record_of_a_box(fish: ht.Robot, tmp_path: Path) -> None:
    (box,) = read(tmp_path / "box.bin", head() + b"".join(tick(k) for k in range(3)))
    record = mission_record(box, fish)
    assert not record.true
    np.testing.assert_allclose(record.time, [0, 0.01, 0.02])
    np.testing.assert_allclose(record.data["bend_read"][:, 0], [0, 0.1, 0.2], rtol=1e-6)
    assert np.isnan(record.data["bend_read"][:, 1]).all()
    assert "in the description: the firmware was built from another" in record.facts["parameters"]
    with pytest.raises(InputError, match="must have the 2 joints of the box, but is 5"):
        mission_record(box, ht.load("rexeel"))


# --- the firmware's own boxes


@pytest.mark.parametrize("board", ["pc", "qemu"])
def test_a_box_has_what_lock_step_saw(fish: ht.Robot, tmp_path: Path, board: str) -> None:
    if (lack := missing(board)) is not None:
        pytest.skip(lack)
    try:
        find_firmware("hypertuna", board)
    except InputError as error:
        pytest.skip(str(error))
    file = tmp_path / "box.bin"
    scenario = find_scenario("gait:unoptimised-0.3", fish)
    run = firmware_in_the_loop(fish, scenario, board=board, ticks=400, black_box=file)
    (box,) = read_black_box(file)
    assert not box.gaps
    assert (box.joints, box.layout) == (2, firmware_table(fish).layout)
    seen, ticks = run.answers, box.ticks
    assert len(ticks) == 400
    assert ticks["tick"].tolist() == list(range(400))
    same = {"quaternion": "attitude_estimated", "position": "position_estimated", "depth": "depth_estimated"}
    same |= {"speed": "speed_estimated"}
    for name in ("quaternion", "position", "depth", "speed", "position_error", "status", "reasons", "faults"):
        np.testing.assert_array_equal(ticks[same.get(name, name)], seen[name], err_msg=name)
    for name in ("mode", "state", "answer"):
        np.testing.assert_array_equal(ticks[name], seen[name], err_msg=name)
    # What the twin's sensors showed, to their noise; the beat that was asked for.
    assert run.mission_run is not None
    at = np.round(run.mission_run.time / 0.01).astype(int)
    off = ticks["bend_read"][at[at < 400]] - run.mission_run.data["angle"][at < 400]
    assert np.sqrt(np.mean(off**2)) < 0.02
    assert np.ptp(ticks["bend_read"]) > 0.2
    assert ticks["frequency_commanded"][-1] == pytest.approx(2)
    assert ticks["armed"].any()
    assert (tmp_path / "box.bin").stat().st_size == 20 + 400 * 216


def test_boards_write_the_same_box(fish: ht.Robot, tmp_path: Path) -> None:
    if (lack := missing("qemu")) is not None:
        pytest.skip(lack)
    files = []
    for board in ("pc", "qemu"):
        try:
            find_firmware("hypertuna", board)
        except InputError as error:
            pytest.skip(str(error))
        files.append(tmp_path / f"{board}.bin")
        firmware_in_the_loop(fish, find_scenario("random"), board=board, ticks=300, seed=2, black_box=files[-1])
    assert files[0].read_bytes() == files[1].read_bytes()


# --- the command


def test_a_box_becomes_a_log(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("foxglove", reason="needs the extra log")
    from hypertuna.mission.read_log import read_log

    box, log, table = tmp_path / "box.bin", tmp_path / "box.mcap", tmp_path / "box.csv"
    box.write_bytes(head() + b"".join(tick(k) for k in range(300) if k != 7))
    code, output, _ = run("log", "black-box", str(box), "-o", str(log), "--json")
    assert code == 0
    found = json.loads(output)
    assert (found["ticks"], found["missing"], found["damaged"], found["boots"]) == (299, 1, 0, 1)
    record = read_log(log).record
    assert set(record.data) <= set(COLUMNS)
    np.testing.assert_allclose(record.data["bend_read"][:, 0], 0.1 * np.delete(np.arange(300), 7), rtol=1e-6)
    assert np.isnan(record.data["bend_read"][:, 1]).all()
    code, output, _ = run("log", "info", str(log), "--json")
    told = json.loads(output)
    assert (code, told["times"], told["complete"]) == (0, 299, True)
    assert "energy_wh" not in told  # nothing measured it
    assert "estimation_error_max_m" not in told  # nobody knows
    assert run("log", "to-csv", str(log), "-o", str(table))[0] == 0
    lines = table.read_text().splitlines()
    place = lines[0].split(",").index("bend_read_II_deg")
    assert {line.split(",")[place] for line in lines[1:]} == {""}
    assert run("log", "plot", str(log), "-o", str(tmp_path / "box.svg"))[0] == 0
    assert ">true<" not in (tmp_path / "box.svg").read_text()
    code, _, errors = run("log", "black-box", str(box), "-o", str(log), "--boot", "2")
    assert (code, "--boot must be from 1 to 1" in errors) == (2, True)
