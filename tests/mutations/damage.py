"""Damage to the content of a file, by a seed: texts, tables and binary files."""

import gzip
import random
import re
from collections.abc import Callable

Damage = Callable[[bytes, random.Random], bytes]
TextDamage = Callable[[str, random.Random], str]

NUMBER = re.compile(r"(?<![\w.\"])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.\"])")
FACTORS = (1e-6, 1e-3, 0.01, 0.1, 0.5, -1.0, 2.0, 10.0, 57.3, 1e3, 1e6)  # units mistaken, above all
EXTREMES = ("0", "-1", "1e300", "-1e300", "1e-300", "1e-5", "1e5", "nan", "inf", "")
VALUES = (*EXTREMES, "true", '"x"', "[]", "{}", "1_0", "0x10", "9" * 30)
SIGNS: tuple[str, ...] = (
    "\0",
    "\x1b[31m",
    "\x07",
    "é",
    "\u202e",
    "\udcff",
    "\ufeff",
    *"$/\"'\n,;=[]#\\",
    "[/b]",
    "",
    "x" * 5000,
)


def of_text(content: bytes, chance: random.Random) -> bytes:
    """Damage a text once to three times: numbers, lines, signs, words, its end."""
    return _repeat(content, chance, TEXT)


def of_table(content: bytes, chance: random.Random) -> bytes:
    """Damage a CSV file once to three times: cells and columns, or as any text."""
    return _repeat(content, chance, TEXT if chance.random() < 0.4 else TABLE)


def of_structure(content: bytes, chance: random.Random) -> bytes:
    """Damage a text as one does who knows how it is parsed: depth, digits, length, repeats, encodings."""
    text = content.decode(errors="surrogateescape")
    for _ in range(chance.choice((1, 1, 2))):
        text = chance.choice(STRUCTURE)(text, chance)
    made = text.encode(chance.choice(("utf-8",) * 20 + ("utf-16", "utf-8-sig", "utf-32")), errors="replace")
    return gzip.compress(gzip.compress(made, 1, mtime=0), 1, mtime=0) if chance.random() < 0.01 else made


def of_bytes(content: bytes, chance: random.Random) -> bytes:
    """Damage a binary file once or twice: bits, lost, repeated and strange bytes, its end."""
    for _ in range(chance.randint(1, 2)):
        begin, length = chance.randrange(len(content) + 1), chance.choice((1, 1, 2, 4, 8, 64, 1000))
        piece, end = content[begin : begin + length], begin + length
        new = chance.choice(
            (
                bytes(byte ^ (1 << chance.randrange(8)) for byte in piece[:1]) + piece[1:],
                b"",
                piece + piece,
                bytes(len(piece)),
                b"\xff" * len(piece),
                chance.randbytes(length) + piece,
            )
        )
        content = content[:begin] + new + content[end:] if chance.random() < 0.9 else content[:begin]
    return content


def _repeat(content: bytes, chance: random.Random, kinds: tuple[TextDamage, ...]) -> bytes:
    """Damage a text once to three times."""
    text = content.decode(errors="surrogateescape")
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        text = chance.choice(kinds)(text, chance)
    return text.encode(errors="surrogateescape")


def _value(old: str, chance: random.Random, values: tuple[str, ...]) -> str:
    """Return another value: the number times a factor, or one of the values."""
    try:
        return f"{float(old) * chance.choice(FACTORS):g}" if chance.random() < 0.6 else chance.choice(values)
    except ValueError:
        return chance.choice(values)


def _number(text: str, chance: random.Random) -> str:
    """Replace a number by another one or by what is none."""
    places = list(NUMBER.finditer(text))
    if not places:
        return text
    at = chance.choice(places)
    return text[: at.start()] + _value(at[0], chance, VALUES) + text[at.end() :]


def _line(text: str, chance: random.Random) -> str:
    """Drop, double or move a line."""
    lines = text.splitlines(keepends=True) or [""]
    at, to = chance.randrange(len(lines)), chance.randrange(len(lines))
    line = lines[at]
    kind = chance.randrange(3)
    if kind != 1:
        del lines[at]
    if kind != 0:
        lines.insert(to, line)
    return "".join(lines)


def _sign(text: str, chance: random.Random) -> str:
    """Insert, drop or change a character."""
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice(SIGNS) + text[at + chance.randrange(2) :]


def _word(text: str, chance: random.Random) -> str:
    """Misspell a key or a name."""
    words = list(re.finditer(r"[A-Za-z_]{3,}", text))
    if not words:
        return text
    at = chance.choice(words)
    word: str = at[0]
    return text[: at.start()] + word[::-1] + text[at.end() :]


def _name(text: str, chance: random.Random) -> str:
    """Put a sign into a quoted name, in all its places."""
    names = re.findall(r'"([^"\n]{1,30})"', text)
    if not names:
        return _word(text, chance)
    name, sign = chance.choice(names), chance.choice(SIGNS)
    sign = sign.encode("unicode_escape").decode() if chance.random() < 0.5 else sign
    return text.replace(f'"{name}"', f'"{name[:1]}{sign}{name[1:]}"')


def _end(text: str, chance: random.Random) -> str:
    """Cut the text short."""
    return text[: chance.randrange(len(text) + 1)]


def _cell(text: str, chance: random.Random) -> str:
    """Change a cell of a table, or one in some of its rows."""
    return _cells(text, chance, chance.choice((1, 1, 3, 20)))


def _column(text: str, chance: random.Random) -> str:
    """Change a column of a table: its unit is mistaken, or it is constant."""
    return _cells(text, chance, None)


def _cells(text: str, chance: random.Random, count: int | None) -> str:
    """Change a column in the given number of rows, or in all, in the same way."""
    rows = [line.split(",") for line in text.split("\n")]
    places = [k for k, row in enumerate(rows) if len(row) > 1 and any(NUMBER.fullmatch(cell.strip()) for cell in row)]
    if not places:
        return text
    column = chance.randrange(len(rows[places[0]]))
    factor, value = chance.choice(FACTORS), chance.choice((*EXTREMES, None, None, None, None, None))
    for k in places if count is None else chance.choices(places, k=count):
        if column < len(rows[k]):
            old = rows[k][column]
            number = f"{float(old) * factor:g}" if NUMBER.fullmatch(old.strip()) else old
            rows[k][column] = number if value is None else value
    return "\n".join(map(",".join, rows))


def _extreme(text: str, chance: random.Random) -> str:
    """Replace a number by one that is too long, too deep or none."""
    places = list(NUMBER.finditer(text))
    at = chance.choice(places) if places else None
    begin, end = (at.start(), at.end()) if at else (len(text), len(text))
    depth, width = chance.choice((30, 200, 1000, 20_000)), chance.choice((100, 1000, 1000, 1000, 100_000))
    value = chance.choice((
        "9" * 400, "9" * 5000, "1" * 50_000, "-" + "9" * 400, "1e999", "-1e999", "0." + "0" * 400 + "1", "NaN", "nan",
        "Infinity", "1" + "0" * 99, "18446744073709551616", "-9223372036854775809", "null", "true", "1e308", "5e-324",
        "[" * depth + "]" * depth, "[" * depth, '{"a":' * depth + "1" + "}" * depth, "{a = " * depth + "}" * depth,
        "<a>" * depth + "</a>" * depth, "<a>" * depth, "[" + "1," * width + "1]", "[" + "[]," * width + "[]]",
        "[" + '{"a":1},' * width + "1]", '"' + "x" * width + '"', '"' * width, "'" * 3 + "\\" * width,
    ))  # fmt: skip
    return text[:begin] + value + text[end:]


def _dotted(text: str, chance: random.Random) -> str:
    """Put a key of many parts, a table of them, or many headings, into a line of its own."""
    lines, parts = text.split("\n"), chance.choice((23, 30, 1000, 20_000))
    key = chance.choice(("a", '"a"', "'b'")) + chance.choice((".", " . ")).join(["", *["a"] * parts])
    heading = next((line for line in chance.sample(lines, len(lines)) if line.startswith("[")), "[a]")
    count = chance.choice((10, 100, 100, 1000, 1000, 40_000))
    new = chance.choice((
        f"{key} = 1", f"[{key}]", f"[[{key}]]", "\n".join([heading] * count), "[[joints]]\n" * count,
        "\n".join(f"k{k} = {k}" for k in range(count)), f"x = {{{key} = 1}}",
        "\n".join(f"[t.{k}]" for k in range(count)),
    ))  # fmt: skip
    at = chance.randrange(len(lines) + 1)
    return "\n".join([*lines[:at], new, *lines[at:]])


def _grown(text: str, chance: random.Random) -> str:
    """Repeat a piece of the text until it is large."""
    begin = chance.randrange(len(text) + 1)
    piece = text[begin : begin + chance.choice((1, 10, 100, 1000))] or ","
    return (
        text[:begin] + piece * (chance.choice((1000,) * 6 + (100_000,) * 3 + (2_000_000,)) // len(piece)) + text[begin:]
    )


def _open(text: str, chance: random.Random) -> str:
    """Open texts that nothing closes, or escape each of their ends."""
    triple = '"' * 3
    piece = chance.choice(("\\" + triple + "\n", '\\"', "'" * 3 + "\n", '"\\\n', "'", triple, "#", '","', "\\\n", '""'))
    at = chance.randrange(len(text) + 1)
    begin = chance.choice(("", triple + "\n", "a = " + triple, "'" * 3))
    return text[:at] + begin + piece * chance.choice((1, 100, 20_000)) + text[at:]


def _ends(text: str, chance: random.Random) -> str:
    """End lines in another way, all of them or one."""
    end = chance.choice(("\r\n", "\r", "\n\r", "\x85", "\u2028", "\x0b", "\x1e", "\n\n", "\n\0", "\n\ufeff"))
    return text.replace("\n", end) if chance.random() < 0.5 else text.replace("\n", end, 1)


def _numeral(text: str, chance: random.Random) -> str:
    """Write a number as other programs do: with underscores, in other scripts, without a value, below the smallest."""
    places = list(NUMBER.finditer(text))
    if not places:
        return text
    at = chance.choice(places)
    return text[: at.start()] + chance.choice(NUMERALS) + text[at.end() :]


def _again(text: str, chance: random.Random) -> str:
    """Give a key again beside itself, with a value of another kind, or in the other case."""
    keys = list(re.finditer(r"[\"']?\b\w{1,60}+[\"']?\s{0,3}[:=]", text))
    if not keys:
        return text
    at = chance.choice(keys)
    key = at[0].swapcase() if chance.random() < 0.3 else at[0]
    value = chance.choice(("1", '"x"', "[]", "null", "{}", "1e400"))
    return text[: at.start()] + key + value + chance.choice((",", "\n", ", ")) + text[at.start() :]


LONG = "x" * 100_000
NUMERALS = (
    *("1e-400", "-1e-400", "-0.0", "1_000", "1_0.5", "+5", "1e5e5", "0x1p3", "0b1", "1,5", "1.", ".5", "5e", "1 000"),
    *("\u0663", "\uff11\uff12", "\u00bd", "\u221e", "\u2212 1", "1\u202e2", "infinity", "-nan", "1e+0000000000001"),
)
STRUCTURE: tuple[TextDamage, ...] = (
    *(_extreme, _extreme, _extreme, _dotted, _grown),
    *(_open, _ends, _numeral, _again),
)
TEXT: tuple[TextDamage, ...] = (_number, _number, _number, _number, _line, _sign, _word, _name, _end)
TABLE: tuple[TextDamage, ...] = (_cell, _cell, _column)
