"""Damaged films: python validation/film/damaged.py [FILMS] [FIRST].

Whole films of four forms, with bits that are turned, parts that are missing, and heads that lie about sizes, counts and
times. Each is opened, sampled and read to its end in gray and in color. It ends in a result or in a sentence, within
10 s and 1 GB; what else happens is printed and makes the exit code 1.
"""

import random
import select
import struct
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from functools import cache
from pathlib import Path

import av
import numpy as np

SECONDS, MEMORY = 10.0, 1e9  # most that reading a film may take [s], [bytes]
# Codec by the film's name
FORMS = {"a.mp4": "libx264", "b.mov": "libx265", "c.mkv": "libx264", "d.avi": "mpeg4"}
# Where boxes of MP4 and chunks of AVI keep sizes, counts and times: name, and offsets in bytes behind it
LIES = {
    **dict.fromkeys((b"mvhd", b"mdhd"), (16, 20)),
    **dict.fromkeys((b"stsz", b"stco", b"stss"), (8, 12)),
    **dict.fromkeys((b"stts", b"stsc", b"ctts", b"elst"), (8, 12, 16)),
    **dict.fromkeys((b"avc1", b"hev1", b"hvc1"), (28,)),
    b"tkhd": (80, 84), b"hdlr": (12,), b"avih": (4, 20, 36, 40), b"strf": (8, 12, 20), b"strh": (24, 28, 36),
}  # fmt: skip


@cache
def whole(name):
    """Return the content of an undamaged film, in which a bar moves."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / name)
        with av.open(path, "w") as out:
            options = {"x265-params": "log-level=none"} if FORMS[name] == "libx265" else {}
            stream = out.add_stream(FORMS[name], rate=60, options=options)
            stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
            draw = np.random.default_rng(0)
            for k in range(48):
                picture = draw.integers(150, 190, (64, 96, 3), dtype=np.uint8)
                picture[20:28, k : k + 16] = (40, 40, 220)
                out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
            out.mux(stream.encode(None))
        return Path(path).read_bytes()


def damaged(seed):
    """Return the name and content of a damaged film."""
    chance = random.Random(seed)
    name = chance.choice(list(FORMS))
    content, kind = bytearray(whole(name)), chance.choice(("bits", "cut", "hole", "lie", "lie", "head"))
    if kind == "bits":
        for _ in range(chance.choice((1, 10, 200))):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif kind == "cut":
        del content[chance.randrange(len(content)) :]
    elif kind == "hole":
        at = chance.randrange(len(content))
        del content[at : at + chance.choice((1, 7, 400))]
    elif kind == "head":  # numbers among the first or the last bytes, where all forms have their heads
        for _ in range(chance.choice((1, 3))):
            at = chance.choice((chance.randrange(600), len(content) - 1 - chance.randrange(1200)))
            content[at : at + 4] = struct.pack(
                ">I", chance.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, chance.getrandbits(32)))
            )
    else:
        known = [box for box in LIES if box in content]
        for box in chance.sample(known, min(len(known), chance.choice((1, 1, 3)))) if known else ():
            at = content.index(box) + 4 + chance.choice(LIES[box])
            value = chance.choice((0, 1, 5000, 0x20002000, 0x7FFFFFFF, 0xFFFFFFFF))
            content[at : at + 4] = struct.pack("<I" if name.endswith("avi") else ">I", value)
    return name, bytes(content)


def read(path):
    """Read a film's samples and all of its frames, in gray and in color; return their number."""
    from hypertuna.film.source import open_film

    film = open_film(path)
    film.sample(5)
    film.sample(5, colors=True)
    return sum(1 for _ in film.frames()) + sum(1 for _ in film.colors(9))


def peak():
    """Return this program's largest memory [bytes]; `getrusage` would count its parent's, too."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def work(first, count):
    """Read damaged films, and print each one's outcome."""
    from hypertuna.errors import InputError

    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            name, content = damaged(seed)
            path = Path(folder) / name
            path.write_bytes(content)
            print(f"{seed} begins", flush=True)
            try:
                found = "read" if read(path) else "empty"
            except InputError as error:
                found = "refused" if len(str(error)) < 700 else f"WRONG {error}"
            except BaseException:
                found = f"WRONG {traceback.format_exc()[-300:]!r}"
            print(f"{seed} {found}" if peak() < MEMORY else f"{seed} WRONG {peak() / 1e6:.0f} MB", flush=True)


def judged(count, first=0):
    """Return how often each outcome came, and what is wrong by seed; films are read in a process that may crash."""
    outcomes, wrong, seed = Counter(), {}, first
    while seed < first + count:
        command = [sys.executable, __file__, "work", str(seed), str(first + count - seed)]
        begun = False
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, bufsize=1
        ) as child:
            while True:
                ready, _, _ = select.select([child.stdout], [], [], SECONDS if begun else 120.0)
                line = child.stdout.readline() if ready else None
                if not line:
                    break
                begun = line.endswith("begins\n")
                if not begun:
                    outcomes[line.split()[1]] += 1
                    if "WRONG" in line:
                        wrong[seed] = line.strip()
                    seed += 1
            child.kill()
        code = child.returncode
        if seed < first + count:
            wrong[seed] = "hangs" if line is None else f"ends the process: {code}"
            seed += 1
    return outcomes, wrong


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:] if text.isdecimal()]
    if "work" in sys.argv:
        work(*numbers)
    else:
        outcomes, wrong = judged(*(numbers or [100]))
        print(dict(outcomes))
        for seed, text in wrong.items():
            print(seed, text)
        sys.exit(bool(wrong))
