"""The same file and seed give the same image, firmware and run on every x86-64 processor, to the last bit.

A processor decides which kernels OpenBLAS, NumPy, the C library and hypertuna take; here, environment variables do.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hypertuna import _core
from program import Run

HERE = Path(__file__).parent
OWN = (("servo", "4"), ("hydraulic", "3"))  # actuation and links
CPU = Path("/proc/cpuinfo")
FLAGS = set(CPU.read_text().partition("\nflags")[2].partition("\n")[0].split()) if CPU.exists() else set()
# What an older processor has not, by the names of NumPy 2 (X86_V3, X86_V4) and 1, and of the C library.
NUMPY = {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"}
LIBRARY = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"}
PROCESSORS = {
    "this one": {},
    "Prescott": {"OPENBLAS_CORETYPE": "Prescott", "HYPERTUNA_ISA": "scalar"} | NUMPY | LIBRARY,
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"} if "avx2" in FLAGS else None,
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX"} if "avx512f" in FLAGS else None,
    **{f"kernels of {isa}": {"HYPERTUNA_ISA": isa} for isa in _core.isas()[:-1]},  # the last are those of "this one"
}


def on_processor(variables: dict[str, str], robots: list[str]) -> dict[str, dict[str, str]]:
    ours = {key: value for key, value in os.environ.items() if not key.startswith(("OPENBLAS_", "NPY_", "HYPERTUNA_"))}
    command = [sys.executable, "-W", "ignore", str(HERE / "digests.py"), *robots]
    done = subprocess.run(command, env=ours | variables, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, str]] = json.loads(done.stdout)
    return found


@pytest.mark.skipif(not FLAGS, reason="chooses among the kernels of x86-64 processors on Linux")
def test_same_bits_on_every_processor(run: Run, tmp_path: Path) -> None:
    robots = ["hypertuna", "rexeel"]
    for actuation, links in OWN:
        robots.append(str(tmp_path / f"{actuation}.toml"))
        given = ("--links", links, "--length", "0.4", "--mass", "1.2", "--actuation", actuation, "--sea")
        assert run("robot", "new", robots[-1], *given)[0] == 0
    chosen = {name: variables for name, variables in PROCESSORS.items() if variables is not None}
    found = {name: on_processor(variables, robots) for name, variables in chosen.items()}
    machines = {json.dumps(one.pop("machine")) for one in found.values()}
    assert len(machines) > 1 or "avx2" not in FLAGS  # the variables are heeded
    for name, one in found.items():
        assert one == found["this one"], name
    assert found["this one"]["hypertuna"].keys() == {"image", "firmware", "twin", "mission"}
