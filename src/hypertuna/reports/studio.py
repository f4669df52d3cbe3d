"""The studio: a self-contained page on which a robot swims in the browser, by the core as WebAssembly."""

from __future__ import annotations

import base64
import contextlib
import gzip
import html
import json
import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.arguments import checked
from hypertuna.description.robot import Robot, load, robot_of, robots
from hypertuna.errors import InputError, shown
from hypertuna.identification.image import sampled_image
from hypertuna.io.door import read_bytes
from hypertuna.io.files import shipped, write_atomically
from hypertuna.mission.read_log import read_log
from hypertuna.ranges import Whole
from hypertuna.swimming.gait import KINDS, NEEDED, Gait, gait_of, gait_text

PAGE = "studio.html"  # file in data/studio
LOG = ".mcap"  # suffix of a mission's log
MODEL = ("water", "joints", "areas")  # options that choose a robot's model
HEIGHTS = Whole(min=200, max=4000)  # px, of a frame in a notebook
_ROBOTS = re.compile(r'(<script type="application/json" id="robots">)(.*?)(</script>)', re.DOTALL)


@dataclass(frozen=True)
class Studio:
    """A page on which a robot swims, computed in the browser; a notebook shows it."""

    robot: Robot
    gait: Gait | None  # at the start; None for the robot's first
    height: int  # of the frame in a notebook [px]
    log: Path | None = None  # file of a mission's log that the page plays

    @property
    def html(self) -> str:
        """The page: one file that needs no other, and no network."""
        return studio_page(self.robot, self.gait, log=self.log)

    def save(self, path: str | Path) -> Path:
        """Write the page, completely or not at all.

        Parameters
        ----------
        path : str or Path
            Of the page; replaced if it exists.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        return write_atomically(path, self.html.encode())

    def __repr__(self) -> str:
        gait = f" at {gait_text(self.gait)}" if self.gait is not None else ""
        gait += f" with the log {self.log.name}" if self.log is not None else ""
        return f"Studio of {self.robot.name}{gait}\nA notebook shows it; save(path) writes the page."

    def _repr_html_(self) -> str:
        title = html.escape(f"Studio of {self.robot.name}")
        style = f"width: 100%; height: {self.height}px; border: 0"
        return f'<iframe title="{title}" style="{style}" srcdoc="{html.escape(self.html)}"></iframe>'


@checked
def studio(
    robot: Robot | str | Path, gait: Gait | str | None = None, *, log: str | Path | None = None, height: int = 720
) -> Studio:
    """Show a swimming robot in a notebook, with a knob for each part of its gait.

    The page computes in the browser, by the same core as Python, and needs no network.

    Parameters
    ----------
    robot : Robot, str or Path
        Robot, its name or the path of its file; or the path of a mission's log, a .mcap file, which the page plays with
        the robot of its name that comes with hypertuna.
    gait : Gait or str, optional
        Gait at the start, or the name of one of the robot's; left out, it is the robot's first.
    log : str or Path, optional
        Mission's log that the page plays with `robot`.
    height : int
        Height of the frame [px].

    Returns
    -------
    Studio
        A notebook shows it; its ``save`` writes the page to a file.

    Raises
    ------
    InputError
        If the gait does not fit the robot, the file is not a mission's log, the log is of a robot that does not come
        with hypertuna or of another than the given one, or an argument is out of range.
    """
    robot, played = robot_and_log(robot, log)
    start_gait = None if gait is None else gait_of(robot, gait)
    return Studio(robot, start_gait, HEIGHTS.check(height, "height", "give the height of the frame in pixels"), played)


def robot_and_log(robot: Robot | str | Path, log: str | Path | None = None) -> tuple[Robot, Path | None]:
    """Return a robot and the log to play with it; `robot` may be the path of a log.

    A log may be a stranger's: of what it names, only robots that come with hypertuna are opened.
    """
    if isinstance(robot, Robot) or Path(robot).suffix != LOG:
        robot = robot_of(robot)
        if log is not None and (name := read_log(log).record.robot) != robot.name:
            fix = "give the robot of the log before it"
            raise InputError(f"must be of the robot {robot.name}", file=str(log), value=f"of {shown(name)}", fix=fix)
        return robot, None if log is None else Path(log)
    if log is not None:
        raise InputError("must be a robot, not a log", key="robot", value=str(robot), fix="give one log")
    name = read_log(robot).record.robot
    if name not in robots():
        rule = f"is of the robot {shown(name)}, which does not come with hypertuna"
        raise InputError(
            rule, file=str(robot), fix="give the robot's file first, and the log as --log (log= in Python)"
        )
    return load(name), Path(robot)


def studio_command(robot: Robot, gait: Gait) -> str:
    """Return the command that opens the studio at a robot and a gait; empty where no file holds the robot."""
    name = next((name for name in (robot.name, robot.file) if name and _holds(name, robot)), None)
    if name is None:
        return ""
    stored, model = load(name).model, robot.model
    words = ["hypertuna studio", shlex.quote(name), f"--frequency {gait.frequency:.10g}"]
    for kind in KINDS if any(gait.bias) else NEEDED:
        words.append(f"--{kind} {','.join(f'{angle:.10g}' for angle in np.degrees(getattr(gait, kind)).round(9))}")
    words += [f"--{key} {getattr(model, key)}" for key in MODEL if getattr(model, key) != getattr(stored, key)]
    return " ".join(words)


def _holds(name: str, robot: Robot) -> bool:
    """Return whether a name or a file holds this robot, whatever its chosen model."""
    with contextlib.suppress(InputError):
        return load(name).using(**{key: getattr(robot.model, key) for key in MODEL}).hash == robot.hash
    return False


def studio_page(robot: Robot, gait: Gait | None = None, *, ledger: str | None = None, log: Path | None = None) -> str:
    """Return the page of the studio with a robot before those that the page already holds.

    `ledger` is the address, as seen from the page, of the ledger's rows, each with the anchor number-ID; empty where
    the page stands in a frame of the ledger, None where there is no ledger. `log` is the file of a mission's log.
    """
    before, tag, content, end, after = _page_parts()
    image = base64.b64encode(gzip.compress(sampled_image(robot), mtime=0)).decode()
    others = [entry for entry in json.loads(content)["robots"] if entry["name"] != robot.name]
    start: dict[str, Any] = {"robot": robot.name}
    if gait is not None:
        start["gait"] = {key: getattr(gait, key) for key in ("frequency", *KINDS)}
    if ledger is not None:
        start["ledger"] = ledger
    data = {"robots": [{"name": robot.name, "image": image}, *others], "start": start}
    # Nothing in the data may end the element of the script that holds it.
    return "".join((before, tag, json.dumps(data).replace("<", "\\u003c"), end, _log_part(log), after))


def _log_part(log: Path | None) -> str:
    """Return the part of a page that holds a log."""
    if log is None:
        return ""
    content = base64.b64encode(read_bytes(log, "log")).decode()
    return f'\n<script type="text/plain" id="log" data-name="{html.escape(log.name)}">{content}</script>'


def _page_parts() -> tuple[str, str, str, str, str]:
    """Return the page that ships with the package, cut before and after the list of its robots."""
    page = shipped_page()
    match = _ROBOTS.search(page)
    if match is None:
        raise InputError("has no place for robots", file=f"data/studio/{PAGE}", fix="build it anew: make studio")
    return page[: match.start()], match[1], match[2], match[3], page[match.end() :]


def shipped_page() -> str:
    """Return the page that ships with the package."""
    try:
        return (shipped("data/studio") / PAGE).read_text(encoding="utf-8")
    except (StopIteration, FileNotFoundError):
        fix = "install hypertuna anew, or run `make studio` in its source tree"
        raise InputError("is missing", file=f"data/studio/{PAGE}", fix=fix) from None
