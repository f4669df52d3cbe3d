"""Work over executors: equal results for every executor, and after the loss of workers."""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kills import building

import hypertuna as ht
from hypertuna.fe.joint_map import joint_map
from hypertuna.mission.seeds import fly_seed_shards, fly_seeds
from hypertuna.optimization.design_space import gait_bounds
from hypertuna.optimization.objective import objective
from hypertuna.optimization.problem import Problem, robust_problem
from hypertuna.parallel.executors import Executors, cluster, map_shards
from models import changed
from program import Run

SPAWN = partial(ProcessPoolExecutor, 2, mp_context=multiprocessing.get_context("spawn"))
GRID = ht.Gaits.grid_degrees(
    frequency=[1 + k / 8 for k in range(24)],
    amplitude=[(8, 12), (16, 25)],
    phase=[(0, 5 * k) for k in range(16)],
    bias=[(0, 0), (2, 3), (4, 4)],
)  # 2304 gaits: three chunks


@pytest.fixture(scope="module")
def whole() -> Any:
    return ht.sweep("hypertuna", GRID)


@pytest.fixture(scope="module")
def dask() -> Iterator[Any]:
    """A cluster of two processes on this machine, which starts a killed one anew."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as local:
        yield local


@pytest.fixture(params=["threads", "processes", "dask"])
def executor(request: pytest.FixtureRequest) -> Iterator[Executors]:
    if request.param == "threads":
        with ThreadPoolExecutor(3) as pool:
            yield pool
    elif request.param == "processes":
        yield SPAWN
    else:
        with cluster(request.getfixturevalue("dask").scheduler_address) as pool:
            yield pool


def test_results_do_not_depend_on_the_executor(executor: Executors, whole: Any, tmp_path: Path) -> None:
    assert ht.sweep("hypertuna", GRID, executor=executor).identical(whole)
    assert ht.sweep_shards("hypertuna", GRID, tmp_path / "a.shards", size=700, executor=executor) == 4
    assert ht.merge_shards(tmp_path / "a.shards").identical(whole)
    assert ht.sweep_shards("hypertuna", GRID, tmp_path / "a.shards", size=700, executor=executor) == 0


def test_workers_may_run_in_another_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path)
    pool = partial(SPAWN, initializer=os.chdir, initargs=("there",))
    assert ht.sweep_shards("hypertuna", GRID, "a.shards", size=700, executor=pool) == 4
    assert ht.merge_shards("a.shards").sizes["frequency"] == 24
    assert list((tmp_path / "there").iterdir()) == []


# --- lost workers


def killer(pids: Callable[[], list[int]], every: int, killed: list[int]) -> Callable[[int, int], None]:
    """Return a report of progress that kills a worker at random, whenever a given number of shards is done."""
    chance = random.Random(7)

    def report(done: int, total: int) -> None:
        if done % every == 0 and done < total and (living := [pid for pid in pids() if not building(pid)]):
            killed.append(chance.choice(living))
            os.kill(killed[-1], signal.SIGKILL)

    return report


def test_a_killed_worker_of_a_cluster_costs_its_shard_only(dask: Any, whole: Any, tmp_path: Path) -> None:
    killed: list[int] = []
    report = killer(lambda: [worker.pid for worker in dask.workers.values() if worker.pid], 12, killed)
    with cluster(dask.scheduler_address) as executor:
        ht.sweep_shards("hypertuna", GRID, tmp_path / "a.shards", size=64, executor=executor, progress=report)
    assert len(killed) == 2
    assert ht.merge_shards(tmp_path / "a.shards").identical(whole)


def test_a_pool_that_lost_a_process_is_made_anew(whole: Any, tmp_path: Path) -> None:
    killed: list[int] = []
    children = multiprocessing.active_children
    report = killer(lambda: [child.pid for child in children() if child.pid], 16, killed)
    ht.sweep_shards("hypertuna", GRID, tmp_path / "a.shards", size=64, executor=SPAWN, progress=report)
    assert killed
    assert ht.merge_shards(tmp_path / "a.shards").identical(whole)


def end_worker(shard: int) -> int:
    if shard == 0:
        time.sleep(0.5)  # still at work when its neighbor ends the pool
    if shard == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return shard


def test_a_shard_that_ends_every_worker_ends_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Told is the shard that does, not one that is lost with it."""
    monkeypatch.setattr("hypertuna.parallel.executors.LOSSES", 1)
    tries = []

    def pool() -> Executor:
        tries.append(1)
        return SPAWN()

    assert list(map_shards(end_worker, [0, 2], SPAWN)) == [0, 2]
    with pytest.raises(ht.InputError, match="lost the worker of shard 1 2 times in a row: give workers more memory"):
        list(map_shards(end_worker, range(3), pool))
    assert 2 <= len(tries) <= 3


def kill_at_the_end(turns: int) -> None:
    for turn in range(turns):
        for value in map_shards(abs, range(3), SPAWN):
            if value == 2:  # the last: one process waits for work and holds the lock of the queue, the other for that
                time.sleep(0.2)
                os.kill(sorted(child.pid or 0 for child in multiprocessing.active_children())[turn % 2], signal.SIGKILL)


def test_a_process_that_is_killed_at_the_end_does_not_hold_up_the_others() -> None:
    """Without the mend each turn hangs in about half of the cases."""
    process = multiprocessing.get_context("spawn").Process(target=kill_at_the_end, args=(6,))
    process.start()
    process.join(120)
    status = process.exitcode
    process.kill()
    assert status == 0


def fail(shard: int) -> int:
    raise ht.InputError("must be odd", key="shard", value=f"{shard}")


def test_an_error_names_its_shard_and_a_broken_pool_says_what_to_do() -> None:
    with ThreadPoolExecutor(2) as pool, pytest.raises(ht.InputError, match="^shard must be odd, but is 4") as error:
        list(map_shards(fail, [4], pool))
    assert error.value.__notes__ == ["in shard 4"]
    with SPAWN() as pool, pytest.raises(ht.InputError, match="^executor lost a process and takes no more work: run"):
        list(map_shards(end_worker, [1], pool))


def test_few_shards_are_in_flight() -> None:
    taken: list[int] = []
    with ThreadPoolExecutor(2) as pool:
        results = map_shards(abs, (taken.append(k) or k for k in range(1000)), pool, in_flight=8)
        assert [next(results) for _ in range(5)] == list(range(5))
        assert len(taken) <= 13
        results.close()


def test_a_cluster_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hypertuna.parallel.executors.TIMEOUT", 1)
    sentence = "^--cluster must be a Dask scheduler that answers, but is tcp://127.0.0.1:9: give the address"
    with pytest.raises(ht.InputError, match=sentence), cluster("tcp://127.0.0.1:9"):
        pass


# One process asks for all of them: each start loads Dask anew.
ASK = """
import sys
from hypertuna.cli.main import main
for address in sys.argv[1:]:
    options = "--frequency 1,2 --amplitude 8,12 --phase 0,20 --cluster".split()
    sys.argv = ["hypertuna", "sweep", *options, address]
    try:
        main()
    except SystemExit as ended:
        print(ended.code, flush=True)
"""


def test_a_wrong_address_ends_at_once_with_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "no.json").write_text('{"address": 3}')
    (tmp_path / "empty.json").write_text("{}")
    wrong = ["nonsense", "ftp://x:1", "no.json", "empty.json", "inproc://a", "tcp://127.0.0.1:99999"]
    ran = subprocess.run([sys.executable, "-c", ASK, *wrong], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    fix = "give the address that `dask scheduler` prints, such as tcp://node1:8786, or its scheduler file"
    sentence = f"error: --cluster must be a Dask scheduler that answers, but is {{}}: {fix}.\n"
    assert (ran.stdout, ran.stderr) == (6 * "2\n", "".join(map(sentence.format, wrong)))


def test_the_shell_names_a_cluster(dask: Any, run: Run, tmp_path: Path) -> None:
    options = ("sweep", "--frequency", "1:4:9", "--amplitude", "8,12", "--phase", "0,0:90:30")
    cluster = ("--cluster", dask.scheduler_address)
    plain, there, shards = (str(tmp_path / name) for name in ("p.csv", "c.csv", "c.shards"))
    assert run(*options, "-o", plain)[0] == 0
    assert run(*options, *cluster, "-o", there) == (0, f"{run(*options)[1]}written: {there}\n", "")
    assert Path(there).read_bytes() == Path(plain).read_bytes()
    code, out, _ = run(*options, *cluster, "--shard-size", "50", "-o", shards, "--json")
    assert (code, json.loads(out)["made"]) == (0, 6)
    assert ht.merge_shards(shards).sizes["phase"] == 30


STEADY = (Path(__file__).parents[2] / "examples" / "tank" / "tank.csv").read_text()


@pytest.mark.parametrize(
    "options",
    [
        ("mission", "box", "--seeds", "0:4", "--duration", "5"),
        ("optimize", "--maximize", "speed", "--method", "pso", "--particles", "6", "--iterations", "2"),
        ("pareto", "--population", "4", "--generations", "1", "--no-polish"),
        ("identify", "tank.csv", "--free", "water.drag[0]", "--starts", "1", "--posterior", "10"),
    ],
    ids=lambda options: options[0],
)
def test_commands_over_a_cluster_print_the_same_numbers(
    dask: Any, run: Run, options: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tank.csv").write_text("\n".join(STEADY.splitlines()[:6]))  # each task takes its four runs along
    monkeypatch.chdir(tmp_path)
    options = (*options, "--robot", "hypertuna", "--json")
    plain, before = run(*options), dask.scheduler.transition_counter
    there = run(*options, "--cluster", dask.scheduler_address)
    assert dask.scheduler.transition_counter > before  # of its tasks: it had some
    assert there[0] == plain[0]
    assert numbers(there[1]) == numbers(plain[1]) != {}


def numbers(text: str) -> Any:
    """Read a JSON object, without the command and the times that work took."""
    told = json.loads(text)
    return {key: value for key, value in told.items() if key not in ("command", "seconds")}


# --- other work that is many


def test_missions_and_twins_do_not_depend_on_the_executor(dask: Any, tmp_path: Path) -> None:
    fish, box = ht.load("hypertuna"), ht.read_mission("box")
    flown = fly_seeds(box, fish, [0, 1, 2], duration=20.0)
    journal = tmp_path / "seeds.journal"
    runs = [{"robot": fish, "gait": "optimised-0.3", "duration": 1.0, "seed": seed} for seed in range(70)]
    swum = ht.twins(runs, measure=speed)
    assert len({*swum}) > 60
    with cluster(dask.scheduler_address) as executor:
        assert fly_seeds(box, fish, [0, 1, 2], duration=20.0, executor=executor, checkpoint=journal) == flown
        assert ht.twins(runs, measure=speed, executor=executor) == swum
        assert fly_seed_shards(box, fish, [0, 1, 2], tmp_path / "a.shards", duration=20.0, executor=executor) == 3
    merged = ht.merge_shards(tmp_path / "a.shards")
    assert merged.distance.values.tolist() == [one.distance for one in flown]
    assert merged.status.values.tolist() == [one.status for one in flown]
    assert fly_seeds(box, fish, [0, 1, 2], duration=20.0, checkpoint=journal) == flown


def speed(run: ht.TwinRun) -> float:
    return float(run.data["x"][-1])


def test_populations_walkers_and_couples_do_not_depend_on_the_executor() -> None:
    fish = ht.load("hypertuna")
    with ThreadPoolExecutor(3) as pool:
        settings: Any = {"population": 20, "generations": 3}
        one, two = (ht.pareto(fish, **settings, executor=executor) for executor in (None, pool))
        assert (one.x == two.x).all()
        assert (one.values == two.values).all()
        search: Any = {"maximize": "speed", "method": "pso", "particles": 20, "iterations": 3}
        assert ht.optimize(fish, **search, executor=pool).gait == ht.optimize(fish, **search).gait
        found = [joint_map(fish, "II", pressure=[0, 1e5], solve=bent, executor=each) for each in (None, pool)]
        assert (found[0].elements.angle == found[1].elements.angle).all()
        plain = Problem(fish, gait_bounds(fish), (objective("speed"),))
        robust = robust_problem(plain, [changed(fish, {"water.density_kg_m3": rho}) for rho in (900, 1100)], "mean")
        x = np.random.default_rng(1).uniform(plain.space.lower, plain.space.upper, (40, 4))
        alone, spread = (replace(robust, executor=each).evaluate(x, derivatives=True) for each in (None, pool))
        for name in ("value", "violation", "value_jacobian", "violation_jacobian"):
            assert (getattr(alone, name) == getattr(spread, name)).all(), name


def bent(couple: float, path: Any) -> dict[str, Any]:
    return {"angle": couple + path[-1][0] / 1e6, "volume": [1e-6, 2e-6], "length": 0.06, "fault": ""}
