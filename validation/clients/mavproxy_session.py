"""A session of MAVProxy, typed by a script: `mavproxy_session.py udp:PORT | tcp:HOST:PORT`. It prints what MAVProxy
prints."""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PATIENCE = 120.0  # s, that an answer may take
MODULES = "param,wp,fence,arm,mode,misc,cmdlong,message,log"  # modules of MAVProxy that are loaded

# A place, a speed, a place 11 m to the north, as a file of waypoints; a square around them.
WAYPOINTS = """QGC WPL 110
0\t1\t3\t16\t5\t3\t0\t0\t{lat:.7f}\t{lon:.7f}\t-0.5\t1
1\t0\t2\t178\t1\t0.3\t-1\t0\t0\t0\t0\t1
2\t0\t3\t16\t0\t3\t0\t0\t{north:.7f}\t{lon:.7f}\t-1.0\t1
"""
# Corners of the fence, by their sides
CORNERS = (("south", "west"), ("south", "east"), ("north", "east"), ("north", "west"))
FENCE = "QGC WPL 110\n" + "".join(  # file of the fence
    f"{k}\t0\t0\t5001\t4\t0\t0\t0\t{{{n}_far:.7f}}\t{{{e}_far:.7f}}\t0\t1\n" for k, (n, e) in enumerate(CORNERS)
)
# Each line that is typed, and what must be printed before the next one is.
SCRIPT = (
    ("", "online system 1"),
    ("param set LINK_RATE 115200", ""),
    ("param fetch", r"Received \d+ parameters"),
    ("param set LEARNING 0.25", ""),
    ("param show LEARNING", "LEARNING         0.25"),
    ("status GLOBAL_POSITION_INT", r"lat : -?\d+"),
    ("fence load {fence}", "MISSION_ACK: TYPE_FENCE: ACCEPTED"),
    ("wp load {waypoints}", "MISSION_ACK: TYPE_MISSION: ACCEPTED"),
    ("wp list", "Saved 3 waypoints"),
    ("arm throttle", "ARMED"),
    ("long 300 0 0 0 0 0 0 0", "MISSION_START: ACCEPTED"),
    ("status HEARTBEAT", "custom_mode : 104"),
    ("long 193 0 0 0 0 0 0 0", "PAUSE_CONTINUE: ACCEPTED"),
    ("status HEARTBEAT", "custom_mode : 105"),
    ("long 193 1 0 0 0 0 0 0", "PAUSE_CONTINUE: ACCEPTED"),
    ("long 20 0 0 0 0 0 0 0", "RETURN_TO_LAUNCH: ACCEPTED"),
    ("long 21 0 0 0 0 0 0 0", "LAND: ACCEPTED"),
    ("long 52510 2 10 15 40 0 0 0", "COMMAND_ACK {{command : 52510, result : 0"),
    ("status HEARTBEAT", "custom_mode : 103"),
    ("disarm", "DISARMED"),
    ("wp clear", "MISSION_ACK: TYPE_MISSION: ACCEPTED"),
    ("fence clear", "MISSION_ACK: TYPE_FENCE: ACCEPTED"),
)


def text_of(path: Path) -> str:
    return path.read_bytes().decode(errors="replace")


def run(program: list[str], folder: Path) -> None:
    """Type the script."""
    transcript = folder / "transcript.txt"
    with transcript.open("wb") as out:
        session = subprocess.Popen(program, stdin=subprocess.PIPE, stdout=out, stderr=subprocess.STDOUT, cwd=folder)
    assert session.stdin is not None
    names: dict[str, str] = {}
    try:
        for typed, wanted in SCRIPT:
            line, needle = typed.format(**names), wanted.replace("{{", r"\{")
            read, end, again = transcript.stat().st_size if typed else 0, time.monotonic() + PATIENCE, time.monotonic()
            repeated = typed.startswith(("status", "param show", "arm")) and bool(wanted)
            while True:
                if typed and time.monotonic() >= again:
                    session.stdin.write(line.encode() + b"\n")
                    session.stdin.flush()
                    again = time.monotonic() + (3.0 if repeated else PATIENCE)
                time.sleep(0.2 if wanted else 1.0)
                if not wanted or re.search(needle, text_of(transcript)[read:]):
                    break
                if time.monotonic() > end:
                    raise SystemExit(f"{line}: no '{needle}' in\n{text_of(transcript)}")
            if typed == "status GLOBAL_POSITION_INT":
                names = files(text_of(transcript)[read:], folder)
    finally:
        session.kill()
        session.wait()
        session.stdin.close()
    print(text_of(transcript))


def files(position: str, folder: Path) -> dict[str, str]:
    """Write the files of waypoints and fence around the robot's position; return their names."""
    lat, lon = (int(re.findall(rf"{key} : (-?\d+)", position)[-1]) / 1e7 for key in ("lat", "lon"))
    far = 4e-4
    values = {"lat": lat, "lon": lon, "north": lat + 1e-4}
    values |= {"south_far": lat - far, "north_far": lat + far, "west_far": lon - far, "east_far": lon + far}
    for name, content in (("waypoints.txt", WAYPOINTS), ("fence.txt", FENCE)):
        (folder / name).write_text(content.format(**values))
    return {"waypoints": "waypoints.txt", "fence": "fence.txt"}


def main(address: str) -> None:
    kind, _, place = address.partition(":")
    master = f"udpin:127.0.0.1:{place}" if kind == "udp" else f"tcp:{place}"
    program = Path(sys.executable).parent / "mavproxy.py"
    with tempfile.TemporaryDirectory() as folder:
        options = [f"--master={master}", f"--state-basedir={folder}", f"--default-modules={MODULES}", "--mav20"]
        run([sys.executable, "-u", "-W", "ignore", str(program), *options], Path(folder))


if __name__ == "__main__":
    main(sys.argv[1])
