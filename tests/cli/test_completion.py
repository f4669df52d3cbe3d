"""Completion by Tab in bash, zsh and fish: each shell runs the script that `--show-completion` prints."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer._completion_shared import get_completion_script

BASH = """
source {script}
COMP_WORDS=({line}) COMP_CWORD={last}
_hypertuna_completion hypertuna
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
FISH = "source {script}; complete -C '{line}' | string split -f 1 \\t"
# What the widgets of zsh would offer: `_arguments` gets the choices as the last group of its argument.
ZSH = """
compdef() {{ :; }}
_files() {{ :; }}
_arguments() {{ print -r -- $1 }}
source {script}
words=({line}) CURRENT={count}
_hypertuna_completion
"""
SHELLS = {"bash": BASH, "fish": FISH, "zsh": ZSH}


def completed(shell: str, line: str, folder: Path) -> set[str]:
    """Return what a shell offers for the last word of a line."""
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    program, script = folder / "hypertuna", folder / "script"
    program.write_text(f"#!{sys.executable}\nfrom hypertuna.__main__ import main\n\nmain()\n", encoding="utf-8")
    program.chmod(0o755)
    text = get_completion_script(prog_name="hypertuna", complete_var="_HYPERTUNA_COMPLETE", shell=shell)
    script.write_text(text, encoding="utf-8")
    count = len(line.split(" "))
    command = SHELLS[shell].format(script=script, line=line, last=count - 1, count=count)
    paths = {"PATH": f"{folder}:{os.environ['PATH']}", "PYTHONPATH": ":".join(sys.path), "HOME": str(folder)}
    done = subprocess.run([shell, "-c", command], capture_output=True, text=True, env=os.environ | paths, check=False)
    assert done.stderr == ""
    if shell != "zsh":
        return set(done.stdout.split())
    return set(re.findall(r'"([^"]+)"(?::"[^"]*")?', done.stdout))  # without the help behind a colon


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_knows_commands_options_and_names(shell: str, tmp_path: Path) -> None:
    def offered(line: str) -> set[str]:
        return completed(shell, line, tmp_path)

    assert offered("hypertuna sw") == {"swim", "sweep"}
    assert offered("hypertuna joint b") == {"bend"}
    assert "--frequency" in offered("hypertuna swim --fre")
    assert offered("hypertuna swim --water s") == {"strip"}
    assert "rexeel" in offered("hypertuna swim --robot rex")
    assert "rexeel" in offered("hypertuna studio rex")
    for name in ("rexeel-mine.toml", "rexeel.mcap", "rexeel.txt"):
        (tmp_path / name).touch()
    assert offered(f"hypertuna studio {tmp_path}/rex") == {f"{tmp_path}/rexeel-mine.toml", f"{tmp_path}/rexeel.mcap"}
    assert offered("hypertuna studio rexeel --gait wave-1") == {"wave-10"}
    assert offered("hypertuna studio --gait turn") == {"turning"}
    assert offered("hypertuna swim --robot rexeel --gait wave-1") == {"wave-10"}
    assert offered("hypertuna mission b") == {"box"}
    assert offered("hypertuna swim --set joints.I.b") == {"joints.I.bandwidth_hz=", "joints.I.bend_max_deg="}
    assert "joints.I.bandwidth_hz=" not in offered("hypertuna swim --robot rexeel --set joints.I")
