"""The door: the only place where users' files are opened; their limits are checked before anything is parsed.

A file must be a regular one: a pipe or a device may never end. Each kind has its largest size in `KINDS`; texts have
limits of depth, numbers and values, archives limits of what they unpack to. A file beyond a limit is an `InputError`.
"""

from __future__ import annotations

import io
import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from hypertuna.errors import InputError

if TYPE_CHECKING:
    import zipfile

    from hypertuna.arrays import Array

MB = 1_000_000  # bytes


class FileKind(NamedTuple):
    """A kind of file: its name, its largest size, and the fix where it is missing."""

    name: str  # with its article, as in errors
    largest: int  # bytes
    fix: str = "check the path"  # if the file is missing


# Kinds of files. Each limit exceeds the size of honest files, and a gigabyte of memory is enough to read it.
KINDS = {
    "toml": FileKind("a TOML file", MB),  # HyperTuna's own has 30 kB, a manifest of 1,000 recordings 300 kB
    "csv": FileKind("a CSV file", 64 * MB),  # half an hour of 12 markers at 60 Hz has 20 MB
    "plan": FileKind("a plan", 5 * MB, "give a .plan, .waypoints, .gpx or .kml file"),  # 1,000 waypoints have 0.5 MB
    "points": FileKind("a file of tracked points", 256 * MB),  # an hour of 12 markers at 60 Hz has 62 MB
    "bag": FileKind("a bag of ROS 2", 256 * MB, "give a .mcap or .db3 file, or the folder of a bag"),
    "log": FileKind("an MCAP file", 256 * MB, "give the path of a .mcap file"),  # of a mission, 40 minutes are read
    "box": FileKind("a black box", 128 * MB, "give the path of a .bin file from the robot's card"),  # 4 hours of ticks
    "journal": FileKind("a journal", 128 * MB),  # a record of a search has 1 kB, a minute of a flight 1.4 MB
    "manifest": FileKind("a manifest of shards", 64 * MB),  # has the labels of all results
    "shard": FileKind("a shard", 256 * MB),  # a million gaits have 200 MB
    "policy": FileKind("a policy", 16 * MB, "give the .npz file that examples/learning/train_goto.py writes"),
    "header": FileKind("a C++ header", MB),  # HyperTuna's has 20 kB
    "key": FileKind("a key", 1000, "make one: openssl rand -out key 32"),
    "scheduler": FileKind("a scheduler file of Dask", MB),
    "state": FileKind("a stored state", 250 * MB, "remove the folder to start over"),  # that of the finest mesh fits
    "surface": FileKind("a surface", 250 * MB, "remove the folder and run `hypertuna fe bend` again"),
    "film": FileKind("a film", 64_000 * MB),  # an hour of a camera at its highest rate has 45 GB; read frame by frame
    "stored": FileKind("a stored result", 16 * MB),  # written by another program of this package
}
DEPTH = 24  # nested tables and lists, and parts of a dotted key
DIGITS = 100  # of a whole number: a float holds it, and a random generator's state has 39
# Bytes of memory that JSON takes per sign, roughly (number or text, half a text, key, list, object), and their limit.
BYTES_PER_SIGN, MAX_MEMORY = {",": 40, '"': 32, ":": 100, "[": 64, "{": 240}, 600 * MB
ENTRIES = 100_000  # values of a TOML file
TABLES = 5_000  # tables in a list of a TOML file
CELLS, ROWS = 3_000_000, 1_000_000  # cells and lines of a table: half an hour of 12 markers at 60 Hz
RUNS = 50_000  # rows of a table whose rows are runs, samples or places, each an object
LONGEST = 100_000  # characters of a table's line
NUMBERS = 12_000_000  # numbers of a binary file of points: an hour of 12 markers at 60 Hz has 8 million
TAGS, TAG = 3_000_000, 10_000  # signs < of a workbook, of which a cell has four; characters of one of its tags
MEMBERS, UNPACKED = 1_000, 32 * MB  # files of an archive, and their bytes when unpacked
DIRECTORY = 300 * MEMBERS  # bytes of an archive's list of files
END, END64 = 22, 20  # bytes of an archive's end record, and of the locator before it in a 64-bit archive
NPY_HEADER = 10_000  # bytes of the header of a .npy file
PIECE = 65_536  # bytes read at a time; shorter JSON needs no check of its memory

# Strings and comments of TOML. An unclosed string matches to the end of its line or file: no end is sought twice.
QUOTED = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*+"{0,5}|'
    r'\'\'\'.*?(?:\'{3,5}|\Z)|"(?:[^"\\\n]|\\.)*+"?|\'[^\'\n]*+\'?|#[^\n]*+',
    re.DOTALL,
)
# Pattern of a dotted key that is nested too deeply
DOTTED = re.compile(rf"(?<![\w.-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEPTH},}}")
LONG_TAG = re.compile(rb"<[^<>]{%d}" % TAG)
# What to do about errors of `tomllib`, which names the line where it gave up.
TOML_FIXES = {
    "Unclosed array": "close the bracket that opens there or on a line above, and write decimals with a point",
    "Cannot overwrite a value": "a key is there twice: delete one of the two lines",
    "Expected newline": "write one key a line, and decimals with a point",
    "Cannot declare": "a table is there twice: put its keys under one heading",
}


def opened(path: str | Path, kind: str, *, file: str | None = None) -> IO[bytes]:
    """Open a regular file of a kind (a key of `KINDS`) for reading; errors name it by `file`, the path by default."""
    name, fix = file or str(path), KINDS[kind].fix
    try:
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOCTTY | os.O_NONBLOCK)  # does not wait for a writer
    except FileNotFoundError:
        raise InputError("must be a file", file=name, value="missing", fix=fix) from None
    except (OSError, ValueError) as error:
        raise _unreadable(name, kind, error) from None
    try:
        check_regular(handle, name, kind)
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def check_regular(handle: int, file: str, kind: str) -> None:
    """Check that an open file is a regular one of at most the size of its kind."""
    status, name = os.fstat(handle), KINDS[kind].name
    if stat.S_ISDIR(status.st_mode):
        raise InputError("is a folder", file=file, fix=f"give the path of {name}")
    if not stat.S_ISREG(status.st_mode):
        raise _endless(file, kind)
    if status.st_size > KINDS[kind].largest:
        raise _too_large(file, kind)


def read_bytes(path: str | Path, kind: str, *, file: str | None = None) -> bytes:
    """Return the whole content of a file."""
    largest = KINDS[kind].largest
    try:
        with opened(path, kind, file=file) as stream:
            size = os.fstat(stream.fileno()).st_size  # memory for this size is allocated
            content: bytes | None = stream.read(size + 1)
            while content and size < len(content) <= largest and (extra := stream.read(PIECE)):
                content += extra
    except OSError as error:
        raise _unreadable(file or str(path), kind, error) from None
    if content is None:  # a pipe in /proc that claims to be a regular file, and is empty now
        raise _endless(file or str(path), kind)
    if len(content) > largest:  # a file without a stated size, as in /proc
        raise _too_large(file or str(path), kind)
    return content


def read_text(path: str | Path, kind: str, *, file: str | None = None) -> str:
    """Read a text file in UTF-8; a table may be in UTF-16, as spreadsheets write it, with a byte order mark."""
    content = read_bytes(path, kind, file=file)
    encoding = "utf-16" if kind == "csv" and content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = io.TextIOWrapper(io.BytesIO(content), encoding=encoding).read()  # turns all line ends into \n
    except ValueError as error:
        raise _unreadable(file or str(path), kind, error) from None
    if kind == "csv" and "\0" in text:
        rule, value = "must be text", "with zero bytes: in UTF-16 without its mark, UTF-32, or no text"
        raise InputError(rule, file=file or str(path), value=value, fix="save it as CSV in UTF-8")
    return text


def read_toml(path: str | Path, *, file: str | None = None) -> dict[str, Any]:
    """Read a TOML file."""
    return parse_toml(read_text(path, "toml", file=file), file=file or str(path))


def parse_toml(text: str, *, file: str | None = None) -> dict[str, Any]:
    """Parse TOML of a sane depth and size."""
    try:
        _check_toml(text)
        document = tomllib.loads(text)
        _check_values(document, ENTRIES, TABLES)
        return document
    except (ValueError, RecursionError) as error:
        fix = next((fix for words, fix in TOML_FIXES.items() if words in str(error)), "correct that line")
        raise InputError("must be valid TOML", file=file, value=f"not ({error})", fix=fix) from None


def parse_json(content: str | bytes) -> Any:
    """Parse JSON of a sane depth and size; ValueError says what is wrong."""
    text = content if isinstance(content, str) else content.decode("utf-8-sig")
    if len(text) > PIECE:
        check_memory(text)
    try:
        value = DECODER.decode(text)
    except RecursionError:
        raise ValueError(f"more than {DEPTH} lists and objects in each other") from None
    if text.count("[") + text.count("{") > DEPTH:
        _check_depth(value)
    return value


def read_npz(path: str | Path, kind: str = "policy", largest: int = UNPACKED) -> dict[str, Array]:
    """Read the arrays of a .npz file of at most `largest` unpacked bytes; headers must agree with their content."""
    import numpy as np  # slow to import

    arrays, numbers = {}, 0
    rule, fix = "must be a whole .npz file of numbers", KINDS[kind].fix
    try:
        with archived(io.BytesIO(read_bytes(path, kind)), largest) as archive:
            for member in archive.infolist():
                content = unpacked(archive, member)
                check_numbers(numbers := numbers + _check_npy(content))
                arrays[member.filename.removesuffix(".npy")] = np.load(io.BytesIO(content), allow_pickle=False)
    except InputError as error:
        raise InputError(error.rule, file=str(path), value=error.value, fix=error.fix or fix) from None
    except damage():
        raise InputError(rule, file=str(path), fix=fix) from None
    return arrays


def read_npy(path: str | Path, kind: str) -> Array | None:
    """Read the numbers of a .npy file; None where it holds pickled Python, which is not read."""
    import numpy as np  # slow to import

    content = read_bytes(path, kind)
    if b"'|O'" in content[:NPY_HEADER]:
        return None
    try:
        check_numbers(_check_npy(content), str(path))
        return np.asarray(np.load(io.BytesIO(content), allow_pickle=False), dtype=float)
    except InputError:
        raise
    except damage():
        raise InputError("must be a whole .npy file of numbers", file=str(path), fix=KINDS[kind].fix) from None


def check_numbers(count: int, file: str | None = None) -> None:
    """Check that a binary file has at most NUMBERS numbers: of a byte each, they become floats of eight."""
    if count > NUMBERS:
        raise InputError(f"must hold at most {NUMBERS} numbers", file=file, value="more", fix="cut it into parts")


def check_tags(archive: zipfile.ZipFile) -> None:
    """Check before parsing that the XML texts of an archive have at most TAGS tags in all, none longer than TAG."""
    tags = 0
    for file in archive.infolist():
        content = unpacked(archive, file)
        tags += content.count(b"<")
        if tags > TAGS or LONG_TAG.search(content):
            rule = f"must have at most {TAGS // 4} cells"
            raise InputError(rule, value="larger", fix="save the sheet as CSV, or cut it into parts")


def damage() -> tuple[type[Exception], ...]:
    """Return the types of errors that reading a damaged archive may raise."""
    import zipfile
    import zlib

    value_errors = (ValueError, KeyError, TypeError, OverflowError, AttributeError, SyntaxError)
    return (OSError, EOFError, RuntimeError, *value_errors, zipfile.BadZipFile, zlib.error)


def archived(stream: IO[bytes], largest: int = UNPACKED, *, stored: bool = False) -> zipfile.ZipFile:
    """Open an archive that has no file twice, and a sane number and size of files, all uncompressed if `stored`."""
    import zipfile  # slow to import

    end = stream.seek(0, os.SEEK_END)
    stream.seek(max(end - END - END64, 0))
    tail = stream.read()
    # The end record must come last: else `zipfile` would search for one before a comment, or for a 64-bit one.
    if not tail[-END:].startswith(b"PK\5\6") or not tail.endswith(b"\0\0") or tail.startswith(b"PK\6\7"):
        raise ValueError("its end is damaged")
    large = int.from_bytes(tail[-10:-6], "little") > DIRECTORY
    archive = None if large else zipfile.ZipFile(stream)
    files = [] if archive is None else archive.infolist()
    if archive is None or len(files) > MEMBERS or sum(file.file_size for file in files) > largest:
        rule = f"must unpack to at most {MEMBERS} files and {largest / MB:.0f} MB"
        raise InputError(rule, value="larger", fix="make it again")
    if len({file.filename for file in files}) < len(files):
        raise ValueError("a file is there twice")
    methods = {zipfile.ZIP_STORED} if stored else {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
    if any(file.compress_type not in methods or file.flag_bits & 1 for file in files):
        raise ValueError("a file is compressed in another way")
    return archive


def unpacked(archive: zipfile.ZipFile, file: zipfile.ZipInfo | str) -> bytes:
    """Return the content of a file in an archive, unpacked to no more bytes than the archive states."""
    with archive.open(file) as content:
        return content.read((archive.getinfo(file) if isinstance(file, str) else file).file_size)


def _check_npy(content: bytes) -> int:
    """Check that the header of an array states numbers, as many as follow it; return how many these are."""
    from numpy.lib import format as npy

    stream = io.BytesIO(content)
    version = npy.read_magic(stream)
    if version not in ((1, 0), (2, 0)):
        raise ValueError("a file of another version")
    read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    try:
        shape, _, dtype = read_header(stream, NPY_HEADER)
    except Exception:  # NumPy parses the header as Python, and may raise any error
        raise ValueError("its header is damaged") from None
    count = math.prod(shape)
    if dtype.hasobject or dtype.kind not in "biufU" or count * dtype.itemsize != len(content) - stream.tell():
        raise ValueError("its shape is not that of its content")
    return count


def _check_toml(text: str) -> None:
    """Check before parsing that TOML is at most DEPTH deep: a dotted key takes memory by the square of its parts."""
    bare = QUOTED.sub(lambda found: "" if found[0][0] == "#" else "q", text)
    depth = 0
    for bracket in re.findall(r"[\[{\]}]", bare):
        depth += 1 if bracket in "[{" else -1
        if depth > DEPTH:
            break
    if depth > DEPTH or DOTTED.search(bare):
        raise ValueError(f"more than {DEPTH} tables and lists in each other")


def check_memory(text: str | bytes) -> None:
    """Check before parsing that JSON will take at most about MAX_MEMORY bytes."""
    occurrences = text.count if isinstance(text, str) else lambda sign: text.count(sign.encode())
    if sum(size * occurrences(sign) for sign, size in BYTES_PER_SIGN.items()) > MAX_MEMORY:
        raise ValueError(f"more values than {MAX_MEMORY / MB:g} MB of memory hold")


def _check_depth(value: Any) -> None:
    """Check that the lists and objects of JSON are at most DEPTH deep."""
    level = [value]
    for _ in range(DEPTH + 1):
        level = [part for item in level if isinstance(item, dict | list) for part in _contents(item)]
        if not level:
            return
    raise ValueError(f"more than {DEPTH} lists and objects in each other")


def _contents(value: dict[str, Any] | list[Any]) -> Iterable[Any]:
    """Return the values that a table or a list holds."""
    return value.values() if isinstance(value, dict) else value


def _parse_whole(text: str) -> int:
    """Return a whole number of at most DIGITS digits."""
    if len(text) > DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text)


DECODER = json.JSONDecoder(parse_int=_parse_whole)


def _check_values(document: dict[str, Any], entries: int, tables: int) -> None:
    """Check depth, number of values and digits of a TOML document."""
    level: list[Any] = [document]
    for _ in range(DEPTH):
        parts: list[Any] = []
        for item in level:
            if isinstance(item, list) and len(item) > tables and any(isinstance(part, dict) for part in item):
                raise ValueError(f"a list of more than {tables} tables")
            parts += _contents(item)
        entries -= len(parts)
        if entries < 0:
            raise ValueError(f"more than {ENTRIES} values")
        if any(isinstance(part, int) and abs(part) >= 10**DIGITS for part in parts):
            raise ValueError(f"a number of more than {DIGITS} digits")
        level = [part for part in parts if isinstance(part, dict | list)]
        if not level:
            return
    raise ValueError(f"more than {DEPTH} tables and lists in each other")


def _unreadable(file: str, kind: str, error: Exception) -> InputError:
    """Return the error of a file that cannot be read."""
    is_text = isinstance(error, UnicodeError)
    value = f"not ({error.strerror if isinstance(error, OSError) else type(error).__name__})"
    return InputError("must be readable", file=file, value=value, fix=f"give {KINDS[kind].name}{' in UTF-8' * is_text}")


def _endless(file: str, kind: str) -> InputError:
    """Return the error of a pipe or a device, which may never end."""
    fix = f"copy what it gives into a file, and give the path of {KINDS[kind].name}"
    return InputError("must be a regular file", file=file, value="a pipe or a device", fix=fix)


def _too_large(file: str, kind: str) -> InputError:
    """Return the error of a file that is too large."""
    rule = f"must be at most {KINDS[kind].largest / MB:g} MB"
    return InputError(rule, file=file, value="larger", fix="cut it, or thin it out")
