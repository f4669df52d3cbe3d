"""Damage logs of a mission and read them as the studio's page and as the program do: python logs.py [LOGS].

The page's reader runs in Node, with a time limit for each log; each of its answers must be a sentence or numbers.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import hypertuna as ht
from hypertuna.mission.read_log import read_log

TOP = Path(__file__).parents[2]
TEST = TOP / "studio/tests/logs.test.mjs"


def main() -> None:
    """Print how many logs page and program read alike."""
    logs = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    with tempfile.TemporaryDirectory() as folder:
        wanted = {"STUDIO_LOGS": f"{logs}", "STUDIO_LOGS_FOLDER": folder}
        subprocess.run(["node", "--test", "--test-reporter=spec", TEST], env=os.environ | wanted, check=True)
        answers = json.loads((Path(folder) / "told.json").read_text())
        pairs = [(answer, program(Path(folder) / answer["name"])) for answer in answers]
    alike = Counter(kind(answer, own) for answer, own in pairs)
    for name, count in alike.most_common():
        print(f"{count:6}  {name}")


def program(path: Path) -> tuple[int, str]:
    """Return how many time steps the program reads from a log, and its error sentence."""
    try:
        log = read_log(path)
    except ht.InputError as error:
        return 0, str(error).replace(f"{path.parent}/", "")
    return len(log.record.time), log.sentence


def kind(page: dict[str, object], own: tuple[int, str]) -> str:
    """Return how two answers compare, without the bracketed parts, which page and program word differently."""
    rows, sentence = own
    if page["rows"] != rows:
        return (
            "read by the page alone" if not rows else "read by the program alone" if not page["rows"] else "other times"
        )
    texts = [re.sub(r" ?\(.*?\)", "", text) for text in (str(page["sentence"]), sentence)]
    return "the same times and sentence" if texts[0] == texts[1] else "the same times, another sentence"


if __name__ == "__main__":
    main()
