"""Run a command of pip behind one line of progress on stderr, and show what it printed only if it fails.

Usage: progress.py TITLE COMMAND...; the status is the command's.
"""

import re
import subprocess
import sys
import time

STEPS = (  # pattern of a line of pip or ninja -> text of the progress
    (re.compile(r"^\s*\[(\d+)/(\d+)\] (?:Building|Linking) "), "compiled {0} of {1}"),
    (re.compile(r"^Collecting ([\w.-]+)"), "package {0}"),
    (re.compile(r"^Installing collected packages"), "installing packages"),
)
COMPILER = re.compile(r"^\s*-- (compiled by .+)")  # a line that CMakeLists.txt prints
EVERY = 5.0  # seconds between lines of progress if stderr is no terminal
TAIL = 100  # last lines of output, shown after a failure


def step(line):
    """Return the text of the progress that a line of output means; None for other lines."""
    return next((text.format(*found.groups()) for form, text in STEPS if (found := form.match(line))), None)


def run(title, command):
    """Run a command, show its steps, and return its status."""
    start, shown, lines, terminal, done = time.monotonic(), 0.0, [], sys.stderr.isatty(), "done"

    def show(text, end):
        lead, rest = ("\r", "\x1b[K") if terminal else ("", "")
        seconds = f"{time.monotonic() - start:.0f} s"
        print(f"{lead}make: {title}: {text}, {seconds}{rest}", end=end, file=sys.stderr, flush=True)

    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as process:
        for line in process.stdout:
            lines.append(line)
            if found := COMPILER.match(line):
                done = f"done, {found[1]}"
            text = step(line)
            if text and (terminal or time.monotonic() - shown >= EVERY):
                shown = time.monotonic()
                show(text, "" if terminal else "\n")
    show("failed" if process.returncode else done, "\n")
    if process.returncode:
        sys.stderr.writelines(lines[-TAIL:])
    return process.returncode


if __name__ == "__main__":
    try:
        sys.exit(run(sys.argv[1], sys.argv[2:]))
    except KeyboardInterrupt:
        sys.exit(130)
