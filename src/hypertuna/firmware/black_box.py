"""Black box: read the record of every tick from the robot's card.

A box is a row of little-endian words (firmware/app/vehicle/black_box.hpp). A record starts with a mark that has its
kind and number of words, and ends with the sum of the partial sums of its words. Its fields are those of
firmware/app/vehicle/record.hpp, bound to `hypertuna._core`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna import _core
from hypertuna.control.mission import Mission
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.firmware.parameters import firmware_table
from hypertuna.io.door import read_bytes
from hypertuna.mission.file import MissionFile
from hypertuna.mission.record import COLUMNS, MissionRecord, names_of

Ticks = NDArray[Any]

WORD, SECTOR = 4, 512  # bytes: of a word, of a sector of the card
HEAD = 3  # words of the first record of a boot
FRAME = 2  # further words of a record: mark, checksum
BLOCKS = (1, 16, 256, 4096)  # records checked at a time: more after good ones
BOOTS, PIECES = 1_000, 30_000  # limits of a file: boots; runs of good records or of damaged bytes
HUGE = 1e12  # the firmware records no larger numbers
MARK = (_core.RECORD_MARK >> 16).to_bytes(2, "little")  # upper half of the first word


@dataclass(frozen=True)
class Box:
    """One boot of a black box."""

    layout: int | None  # checksum of the firmware's parameters; None if the record that holds it is damaged
    joints: int
    ticks: Ticks  # (T,) of record_dtype: the complete records, in order of time
    damaged: int  # number of places with wrong checksums or foreign bytes, and of implausible records
    skipped: int  # bytes at those places
    cut: int  # bytes of an incomplete record at the end

    @property
    def missing(self) -> int:
        """Number of ticks between the first and the last without a complete record."""
        clock = self.ticks["tick"]
        return int(clock[-1]) - int(clock[0]) + 1 - len(clock)

    @property
    def gaps(self) -> bool:
        """Whether ticks are missing or bytes damaged."""
        return bool(self.damaged or self.missing or self.cut)

    @property
    def sentence(self) -> str:
        """Sentence on the box: that it is complete, or what is missing and damaged."""
        if not self.gaps:
            return "The box is complete: no tick is missing, all checksums are right."
        damage = f"; damaged in {self.damaged} places, {self.skipped} bytes skipped" if self.damaged else ""
        cut = f"; cut short within a record, {self.cut} bytes ignored" if self.cut else ""
        total = len(self.ticks) + self.missing
        return f"The box has gaps: {self.missing} of {total} ticks are missing{damage}{cut}."


def record_dtype(joints: int) -> np.dtype[Any]:
    """Return the fields of a tick's record: names of `hypertuna.mission.record.COLUMNS`, and the tick."""
    fields: list[Any] = []
    for name, number, count in _core.record_fields(joints):
        if " " in name:
            fields += [(part, "u1") for part in name.split()]
        else:
            fields.append((name, "<f4" if number else "<u4", *([(count,)] if count > 1 else [])))
    return np.dtype(fields)


def read_black_box(path: str | Path, report: Callable[[int, int], None] | None = None) -> list[Box]:
    """Read a black box boot by boot; damaged bytes are skipped and counted. `report(bytes read, all bytes)`."""
    file = str(path)
    content = _without_blanks(read_bytes(path, "box"))
    boots: list[_Boot] = []
    before_boot = b""  # bytes before the first record
    for piece in _pieces(content, file, report):
        if isinstance(piece, bytes):
            if boots:
                boots[-1].skip(piece)
            before_boot = before_boot or piece
        elif (kind := int(piece[0, 0]) >> 8 & 0xFF) == _core.RECORD_ROBOT:
            boots.append(_Boot(*_boot_header(piece[-1, 1:-1], file)))
        elif boots or (joints := _joints_of(piece, kind)):
            if not boots:
                boots.append(_Boot(None, joints))  # its first record is damaged
                boots[0].skip(before_boot)
            boots[-1].take(piece, tick=kind == _core.RECORD_TICK)
    if not boots:
        fix = "give a .bin file from the robot's card, or of `hypertuna hil --black-box`"
        raise InputError("must be a black box: it has no header", file=file, value="something else", fix=fix)
    boxes = [box for boot in boots if boot.ticks for box in boot.boxes()]
    if not boxes:
        raise InputError("must have complete records", file=file, value="without", fix="record again")
    if len(boxes) > BOOTS:
        raise InputError(f"must have at most {BOOTS} boots", file=file, value=f"{len(boxes)}", fix="cut the file")
    return boxes


def _without_blanks(content: bytes) -> bytes:
    """Return a box without the blank sectors at its end, laid out on the card but not written."""
    for blank in (b"\0", b"\xff"):
        length = -(-len(content.rstrip(blank)) // SECTOR) * SECTOR
        content = content if len(content) % SECTOR else content[:length]
    return content


def _pieces(content: bytes, file: str, report: Callable[[int, int], None] | None) -> Iterator[Ticks | bytes]:
    """Yield runs of complete records of one kind, each as a table of words, and the bytes between them as bytes."""
    position = begin = tried = 0
    while position < len(content):
        if (tried := tried + 1) > PIECES:
            rule = f"must be a black box: it is damaged in more than {PIECES} places"
            raise InputError(rule, file=file, fix="copy it from the card again")
        if (table := _table(content, position)) is None:
            next_mark = content.find(MARK, position + 3)  # the next record begins at the next byte at the earliest
            position = len(content) if next_mark < 0 else next_mark - 2
        if begin < position and (table is not None or position == len(content)):
            yield content[begin:position]
            begin = position
        if table is not None:
            yield table
            position = begin = position + table.nbytes
        if report is not None:
            report(position, len(content))


def _table(content: bytes, begin: int) -> Ticks | None:
    """Return the complete records of one kind that begin at a position; None if there are none."""
    mark = int.from_bytes(content[begin : begin + WORD], "little")
    width = (mark & 0xFF) + FRAME
    available = (len(content) - begin) // (WORD * width)
    if mark >> 16 != _core.RECORD_MARK >> 16 or not available:
        return None
    for block in BLOCKS:
        count = min(block, available)
        table = np.frombuffer(content, "<u4", count * width, begin).reshape(count, width)
        sums = np.cumsum(table[:, :-1], axis=1, dtype=np.uint32).sum(axis=1, dtype=np.uint32)
        good = (table[:, 0] == mark) & (table[:, -1] == sums)
        if not good.all():
            break
    return table[: count if good.all() else int(np.argmin(good))] if good[0] else None


def _boot_header(words: Ticks, file: str) -> tuple[int, int]:
    """Return layout of the parameters and number of joints of a boot."""
    layout = int(words[0]) if len(words) == HEAD else 0
    if layout != _core.RECORD_LAYOUT:
        rule = f"must have the layout {_core.RECORD_LAYOUT:08x}"
        fix = "read it with the version of hypertuna that built the firmware"
        raise InputError(rule, file=file, key="records", value=f"{layout:08x}", fix=fix)
    if not 1 <= words[2] <= _core.BOARD_JOINTS:
        rule, value = f"must be of 1 to {_core.BOARD_JOINTS} joints", f"of {words[2]}"
        raise InputError(rule, file=file, key="records", value=value, fix="give the file as it is on the card")
    return int(words[1]), int(words[2])


def _joints_of(table: Ticks, kind: int) -> int:
    """Return the number of joints of tick records, by their size; 0 for other records."""
    tick_bytes = WORD * (table.shape[1] - FRAME) if kind == _core.RECORD_TICK else 0
    return next((n for n in range(1, _core.BOARD_JOINTS + 1) if record_dtype(n).itemsize == tick_bytes), 0)


def _plausible(ticks: Ticks) -> NDArray[np.bool_]:
    """Return whether each tick (T,) has only numbers that the firmware can record."""
    good = np.ones(len(ticks), bool)
    for name in ticks.dtype.names or ():
        values = ticks[name].reshape(len(ticks), -1)
        if values.dtype.kind == "f" and name in COLUMNS:
            good &= ((np.abs(values) < HUGE) | (np.isnan(values) & COLUMNS[name].silent)).all(axis=1)
    return good


def _out_of_order(clock: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return whether each tick of a clock (T,) is a repeat, or out of order between two that are in order."""
    before, after = clock[:-2], clock[2:]
    alone = np.zeros(len(clock), bool)
    alone[1:] = np.diff(clock) == 0
    alone[1:-1] |= (before < after) & ((clock[1:-1] < before) | (clock[1:-1] > after))
    return alone


class _Boot:
    """A boot while it is read: records of its ticks, and counts of damage."""

    def __init__(self, layout: int | None, joints: int) -> None:
        self.layout, self.joints, self.dtype = layout, joints, record_dtype(joints)
        self.ticks: list[Ticks] = []
        self.damaged = self.skipped = self.cut = 0

    def take(self, table: Ticks, *, tick: bool) -> None:
        """Add records of ticks; skip records of another kind or size."""
        if not tick or WORD * (table.shape[1] - FRAME) != self.dtype.itemsize:
            return self.skip(table.tobytes())
        self.cut = 0
        self.ticks.append(np.ascontiguousarray(table[:, 1:-1]).view(self.dtype)[:, 0])

    def skip(self, content: bytes) -> None:
        """Count bytes that are no complete record."""
        self.damaged, self.skipped = self.damaged + 1, self.skipped + len(content)
        # They may be an incomplete record at the end of the file: a mark, and fewer words than it announces.
        begins = content[2:WORD] == MARK and len(content) < WORD * (content[0] + FRAME)
        self.cut = len(content) if begins or len(content) < WORD else 0

    def boxes(self) -> list[Box]:
        """Return the boxes of the boot: one, or several where the clock starts again after a damaged first record.

        An incomplete record at the end is no damage.
        """
        damaged, skipped = self.damaged - bool(self.cut), self.skipped - self.cut
        ticks = np.concatenate(self.ticks)
        good = _plausible(ticks)
        good[good] = ~_out_of_order(ticks["tick"][good].astype(np.int64))
        rejected = len(ticks) - int(good.sum())
        ticks = ticks[good]
        parts = np.split(ticks, np.flatnonzero(np.diff(ticks["tick"].astype(np.int64)) <= 0) + 1)
        counts = (damaged + rejected, skipped + rejected * self.dtype.itemsize)
        boxes = [Box(None, self.joints, part, 0, 0, 0) for part in parts if len(part)]
        if boxes:
            boxes[0] = replace(boxes[0], layout=self.layout, damaged=counts[0], skipped=counts[1])
            boxes[-1] = replace(boxes[-1], cut=self.cut)
        return boxes


def mission_record(
    box: Box, robot: Robot, file: MissionFile | None = None, facts: Mapping[str, str] | None = None
) -> MissionRecord:
    """Return a box as a record of a mission, with waypoints, fence and origin of `file`."""
    if box.joints != len(robot.joints):
        rule, fix = f"must have the {box.joints} joints of the box", "give the robot of the box by --robot"
        raise InputError(rule, key=f"robot {robot.name}", value=f"{len(robot.joints)}", fix=fix)
    table = firmware_table(robot)
    assert robot.controller is not None  # the table has its numbers
    layout = "unknown: the first record of the boot is damaged"
    if box.layout is not None:
        layout = f"layout {box.layout:08x}, as in the description"
        if box.layout != table.layout:
            layout = layout.replace("as in the", f"but {table.layout:08x} in the")
            layout += ": the firmware was built from another"
    source = provenance(robot, water=False) | {"source": "black box", "status_text": box.sentence, "parameters": layout}
    with np.errstate(invalid="ignore"):  # no warning for a signaling NaN
        data = {name: box.ticks[name].astype(float) for name in box.ticks.dtype.names or () if name in COLUMNS}
    start = tuple(data["position_estimated"][0].tolist())
    return MissionRecord(
        name="black box" if file is None else file.name,
        robot=robot.name,
        mission=Mission((), start=start, home=start) if file is None else file.mission,
        time=box.ticks["tick"] / robot.controller.rate,
        data=data,
        origin=None if file is None else file.origin,
        facts={key: str(value) for key, value in (source | dict(facts or {})).items()},
        **names_of(robot),
    )
