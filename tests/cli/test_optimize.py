"""The commands `hypertuna optimize`, `optimize ask` and `optimize tell`."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit

import hypertuna as ht
from hypertuna.optimization.optimize import optimize
from program import Run

SMALL = ("optimize", "--robot", "hypertuna", "--particles", "5", "--iterations", "3")
TANK = ("--robot", "hypertuna", "--maximize", "speed", "--method", "pso", "--particles", "4", "--iterations", "2")


def strict(text: str) -> dict[str, Any]:
    """Read JSON that has no NaN or infinity."""
    value = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert isinstance(value, dict)
    return value


@pytest.mark.parametrize("layout", ["inline", "dotted"])
def test_the_best_gait_is_written_into_any_layout(run: Run, tmp_path: Path, layout: str) -> None:
    """tomlkit cannot add a table to an inline one, nor to dotted keys: the result must not be lost."""
    document = ht.load("rexeel-theory").document()
    gait = document.pop("gaits").popitem()[1]
    del document["sources"]
    gaits = {
        "inline": "gaits = {a = {" + ", ".join(f"{key} = {value}" for key, value in gait.items()) + "}}\n",
        "dotted": "".join(f"gaits.a.{key} = {value}\n" for key, value in gait.items()),
    }
    file, output = tmp_path / "fish.toml", tmp_path / "best.toml"
    file.write_text(gaits[layout] + tomlkit.dumps(document), encoding="utf-8")
    code, _, errors = run("optimize", "--robot", str(file), *SMALL[3:], "--maximize", "speed", "-o", str(output))
    assert (code, errors) == (0, "")
    best = ht.load(output)
    assert {"a", "best"} <= set(best.gaits)


def test_a_place_that_cannot_be_written_is_told_before_the_search(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "best.toml"
    folder.mkdir()
    code, _, errors = run(*SMALL, "--speed", "0.4", "-o", str(folder))
    assert (code, "--output must be a file that can be written" in errors) == (2, True)


def test_json_says_what_the_function_finds(run: Run) -> None:
    code, output, _ = run(*SMALL, "--speed", "0.4", "--seed", "3", "--method", "pso", "--json")
    told = strict(output)
    best = optimize(ht.load("hypertuna"), speed=0.4, method="pso", particles=5, iterations=3, seed=3)
    assert code == 0
    assert best.gait is not None
    assert told["gait"] == {
        "frequency_hz": best.gait.frequency,
        "amplitude_deg": np.degrees(best.gait.amplitude).round(10).tolist(),
        "phase_deg": np.degrees(best.gait.phase).round(10).tolist(),
    }
    assert told["speed_m_s"] == best.speed
    assert told["cost_of_transport_j_per_kg_m"] == best.cost_of_transport
    assert told["evaluations"] == 15
    assert told["seconds"] > 0
    assert told["stop"] == "All 3 iterations of 5 particles are done."
    assert told["history"] == best.history.tolist()
    assert told["seed"] == 3
    assert told["robot_hash"] == best.robot.hash


def test_json_and_table_say_how_flat_the_best_is(run: Run) -> None:
    wish = (*SMALL[:3], "--maximize", "speed", "--method", "gradient")
    told = strict(run(*wish, "--json")[1])
    assert told["near_best"].keys() == {"frequency_hz", "amplitude_I_deg", "amplitude_II_deg", "phase_II_deg"}
    low, high = told["near_best"]["phase_II_deg"]
    assert low < told["gait"]["phase_deg"][1] < high
    sentence = f"The best is flat: within 0.5 % of it for phase II from {low:.3g} to {high:.3g} deg."
    assert told["remark"] == sentence
    assert sentence in run(*wish)[1]


def test_table_names_bounds_and_limits(run: Run) -> None:
    limits = ("--max-joint-rate", "300", "--amplitude-by-bandwidth", "--min-speed", "0.2", "--strouhal", "0.1:2")
    bounds = ("--bounds", "phase_II=0:20", "--bounds", "amplitude_I_deg=5:9")
    code, output, _ = run(*SMALL[:3], "--maximize", "speed", "--method", "gradient", *limits, *bounds)
    assert code == 0
    assert "9  deg (upper bound)" in output
    assert "(at most 300, active)" in output or "(at most 1, active)" in output
    assert "m/s (at least 0.2)" in output
    assert "gradient searches have ended" in output


def test_limits_stand_in_json_with_their_margins(run: Run) -> None:
    code, output, _ = run(*SMALL, "--maximize", "speed", "--max-joint-rate", "200", "--max-torque", "3", "--json")
    told = strict(output)
    assert code == 0
    assert [c["name"] for c in told["constraints"]] == ["rate_I", "rate_II", "torque_peak"]
    for limit in told["constraints"]:
        assert limit["margin"] == pytest.approx(1 - limit["value"] / limit["limit"])
        assert limit["value"] <= limit["limit"]
    assert [c["unit"] for c in told["constraints"]] == ["deg/s", "deg/s", "N m"]


def test_impossible_limits_are_exit_code_1(run: Run) -> None:
    code, output, _ = run(*SMALL, "--maximize", "speed", "--min-speed", "3", "--json")
    told = strict(output)
    assert code == 1
    assert told["gait"] is None
    assert told["speed_m_s"] is None
    assert "No gait was found that satisfies all limits" in told["stop"]
    code, output, _ = run(*SMALL, "--maximize", "speed", "--min-speed", "3")
    assert code == 1
    assert "No gait was found" in output


def test_speed_out_of_reach_is_remarked(run: Run) -> None:
    _, output, _ = run(*SMALL, "--speed", "2")
    assert "instead of the expected 2 m/s" in " ".join(output.split())


def test_convergence_is_drawn(run: Run, tmp_path: Path) -> None:
    code, output, _ = run(*SMALL, "--maximize", "speed", "--plot", str(tmp_path / "convergence.svg"))
    assert code == 0
    assert "written" in output
    picture = (tmp_path / "convergence.svg").read_text()
    assert "speed [m/s]" in picture
    assert "gaits swum" in picture


def test_best_gait_swims_from_the_file_written(run: Run, tmp_path: Path) -> None:
    path = str(tmp_path / "best.toml")
    wish = ("--maximize", "speed", "--method", "gradient", "--joints", "ideal")
    best = strict(run("optimize", "--robot", "hypertuna", *wish, "-o", path, "--json")[1])
    swum = strict(run("swim", "--robot", path, "--gait", "best", "--json")[1])
    assert swum["speed_m_s"] == pytest.approx(best["speed_m_s"], rel=1e-9)
    assert "# Table II" in Path(path).read_text()  # comments stay
    again = ht.load(path)
    assert again.gaits.keys() - {"best"} == ht.load("hypertuna").gaits.keys()
    assert "hypertuna optimize" in (again.source("gaits.best.frequency_hz") or "")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((*SMALL, "--maximize", "speed", "--bounds", "frequency"), "--bounds must be NAME=LOW:HIGH"),
        ((*SMALL, "--maximize", "speed", "--bounds", "frequency=1"), "--bounds frequency must be LOW:HIGH"),
        ((*SMALL, "--maximize", "speed", "--bounds", "frequency=1:x"), "--bounds frequency must be a number"),
        ((*SMALL, "--maximize", "speed", "--strouhal", "0.2"), "--strouhal must be LOW:HIGH"),
        ((*SMALL, "--maximize", "speed", "--seed", "x"), "--seed must be a whole number"),
        ((*SMALL, "--maximize", "speed", "--plot", "x.txt"), "--plot must end in .svg, .png or .pdf"),
        ((*SMALL, "--maximize", "speed", "--checkpoint", "/"), "/ must be a writable file"),
        ((*SMALL, "--speed", "0"), "speed must be greater than 0"),
        ((*SMALL, "--maximize", "speed", "ask", "--state", "x"), "--robot must come after ask"),
    ],
)
def test_bad_input_is_exit_code_2(run: Run, arguments: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run(*arguments)
    assert code == 2
    assert sentence in errors
    assert errors.startswith("error: ")
    assert "Traceback" not in errors + output


@pytest.fixture
def state(tmp_path: Path) -> str:
    """A file for the state of an experiment, not made yet."""
    return str(tmp_path / "run.jsonl")


def filled(batch: Path, speeds: list[str]) -> str:
    """Fill measured speeds into the first gaits of a batch that was written; the others are left out."""
    head, *rows = batch.read_text().splitlines()
    rows = [row.removesuffix(",,") + f",{speed}," for row, speed in zip(rows, speeds, strict=False)]
    batch.write_text("\n".join([head, *rows]) + "\n")
    return str(batch)


def test_experiment_from_first_gait_to_the_best(run: Run, state: str, tmp_path: Path) -> None:
    batch = tmp_path / "batch.csv"
    code, output, _ = run("optimize", "ask", "--state", state, *TANK, "-o", str(batch))
    assert code == 0
    assert output.count("batch-1-gait-") == 4
    assert run("optimize", "ask", "--state", state)[1] in output  # the same gaits again

    code, output, _ = run("optimize", "tell", "--state", state, filled(batch, ["0.1", "0.4", "0.2", "0.3"]))
    assert code == 0
    assert "4 recorded; none of this batch remaining" in output
    assert output.count("batch-2-gait-") == 4

    values = [part for speed in ("0.2", "0.1", "0.3,1.5", "0.2") for part in ("--value", speed)]
    told = strict(run("optimize", "tell", "--state", state, *values, "--json")[1])
    assert told["stop"] == "All 2 iterations of 4 particles are done."
    assert told["gaits"] == []
    assert told["best"]["speed_m_s"] == 0.4
    assert told["evaluations"] == 8
    code, output, _ = run("optimize", "ask", "--state", state)
    assert code == 0
    assert "All 2 iterations of 4 particles are done." in output
    assert "speed_m_s 0.4" in output


def test_experiment_told_in_parts_asks_for_the_rest(run: Run, state: str, tmp_path: Path) -> None:
    batch = tmp_path / "batch.csv"
    run("optimize", "ask", "--state", state, *TANK, "-o", str(batch))
    whole = batch.read_text()
    run("optimize", "tell", "--state", state, filled(batch, ["0.1", "0.4"]))
    rest = strict(run("optimize", "ask", "--state", state, "--json")[1])
    assert [gait["run"] for gait in rest["gaits"]] == ["batch-1-gait-03", "batch-1-gait-04"]
    code, _, errors = run("optimize", "tell", "--state", state, str(batch))
    assert code == 2
    assert "line 2 must be a gait of the current batch that is not measured yet" in errors
    run("optimize", "tell", "--state", state, "--value", "0.2", "--value", "0.3")
    parts = run("optimize", "ask", "--state", state, "--json")[1]

    other = str(tmp_path / "other.jsonl")
    run("optimize", "ask", "--state", other, *TANK)
    batch.write_text(whole)
    run("optimize", "tell", "--state", other, filled(batch, ["0.1", "0.4", "0.2", "0.3"]))
    assert run("optimize", "ask", "--state", other, "--json")[1] == parts


def test_what_was_told_feeds_identify(run: Run, state: str, tmp_path: Path) -> None:
    batch = tmp_path / "batch.csv"
    run("optimize", "ask", "--state", state, *TANK, "-o", str(batch))
    runs = ht.read_trials(filled(batch, ["0.1", "0.4", "0.2", "0.3"]), ht.load("hypertuna"))
    assert [trial.speed for trial in runs.steady] == [0.1, 0.4, 0.2, 0.3]


@pytest.mark.parametrize(
    ("speeds", "sentence"),
    [
        (["nan", "0.1", "0.1", "0.1"], "line 2, speed_m_s must be a finite number"),
        (["0.1", "", "0.1", "0.1"], "line 3"),
        (["0.1", "fast", "0.1", "0.1"], "line 3, speed_m_s must be a number"),
    ],
)
def test_bad_rows_are_told_by_line_and_nothing_is_kept(
    run: Run, state: str, tmp_path: Path, speeds: list[str], sentence: str
) -> None:
    batch = tmp_path / "batch.csv"
    before = run("optimize", "ask", "--state", state, *TANK, "-o", str(batch))[1]
    code, _, errors = run("optimize", "tell", "--state", state, filled(batch, speeds))
    assert code == 2
    assert sentence in errors
    assert run("optimize", "ask", "--state", state)[1] in before


def test_gaits_that_were_not_asked_for_are_refused(run: Run, state: str, tmp_path: Path) -> None:
    batch = tmp_path / "batch.csv"
    run("optimize", "ask", "--state", state, *TANK, "-o", str(batch))
    path = filled(batch, ["0.1", "0.2", "0.3", "0.4"])
    text = batch.read_text().splitlines()
    cells = text[3].split(",")
    batch.write_text("\n".join([*text[:3], ",".join([cells[0], f"{float(cells[1]) + 0.1}", *cells[2:]]), text[4]]))
    code, _, errors = run("optimize", "tell", "--state", state, path)
    assert code == 2
    assert "line 4 must be a gait of the current batch" in errors
    batch.write_text("\n".join([*text, text[1].replace("gait-01", "again")]))
    code, _, errors = run("optimize", "tell", "--state", state, path)
    assert code == 2
    assert "line 6 must be a gait of the current batch that is not measured yet" in errors


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("ask",), "does not exist"),
        (("ask", *TANK[:4], "--method", "gradient"), "must work without derivatives, which a tank cannot measure"),
        (("ask", *TANK[:2], "--maximize", "efficiency"), "efficiency must be measured in the tank"),
        (("ask", *TANK[:2]), "must be one of --maximize, --minimize and --speed"),
        (("tell", "--value", "0.1"), "does not exist"),
        (("tell",), "does not exist"),
    ],
)
def test_experiment_that_cannot_begin_leaves_no_file(
    run: Run, state: str, arguments: tuple[str, ...], sentence: str
) -> None:
    command, *rest = arguments
    code, _, errors = run("optimize", command, "--state", state, *rest)
    assert code == 2
    assert sentence in errors
    assert not Path(state).exists()


def test_another_search_in_the_same_file_is_refused(run: Run, state: str) -> None:
    run("optimize", "ask", "--state", state, *TANK)
    code, _, errors = run("optimize", "ask", "--state", state, *TANK, "--seed", "2")
    assert code == 2
    assert "was started with seed = 1, but now it is 2" in errors
    code, _, errors = run("optimize", "ask", "--state", state, "--seed", "2")
    assert code == 2
    assert "--seed needs --robot: without it, the state file continues with its own options" in errors
    for arguments in ((), ("--value", "0.1", "file.csv")):
        code, _, errors = run("optimize", "tell", "--state", state, *arguments)
        assert code == 2
        assert "must be given either in a CSV file or with --value" in errors
    code, _, errors = run("optimize", "tell", "--state", state, *("--value", "0.1") * 5)
    assert code == 2
    assert "--value must be given at most 4 times" in errors


def with_checksums(*records: dict[str, Any]) -> str:
    """Lines of a journal, each with the checksum of itself and all before it: changed by somebody who knows how."""
    text, checksum = "", 0
    for record in records:
        line = json.dumps({key: value for key, value in record.items() if key != "crc32"}, ensure_ascii=False)
        checksum = zlib.crc32(line.encode(), checksum)
        text += f'{line[:-1]}, "crc32": "{checksum:08x}"}}\n'
    return text


def test_states_that_were_tampered_with_are_told(run: Run, state: str) -> None:
    run("optimize", "ask", "--state", state, *TANK)
    run("optimize", "tell", "--state", state, *("--value", "0.1") * 4)
    whole = Path(state).read_text()
    header, record = map(json.loads, whole.splitlines())
    assert with_checksums(header, record) == whole
    for changes, sentence in (
        ({"options": 3}, "must be a journal of hypertuna"),
        ({"options": {"robot": "hypertuna"}}, ":1 does not hold the options of its first call"),
    ):
        Path(state).write_text(with_checksums(header | changes))
        code, _, errors = run("optimize", "ask", "--state", state)
        assert (code, sentence in errors) == (2, True), errors
    for changes in ({"told": 3}, {"told": []}, {"told": [3] * 4}, {"asked": None}):
        Path(state).write_text(with_checksums(header, record | changes))
        code, _, errors = run("optimize", "ask", "--state", state)
        assert (code, ":2 holds gaits that are not in this search" in errors) == (2, True), errors


def test_cost_of_transport_that_the_goal_needs_must_be_told(run: Run, state: str) -> None:
    search = (*TANK[:2], "--speed", "0.3", *TANK[4:])
    run("optimize", "ask", "--state", state, *search)
    code, _, errors = run("optimize", "tell", "--state", state, *("--value", "0.3") * 4)
    assert code == 2
    assert "batch-1-gait-01 must have a cost of transport, which the objective needs" in errors
    code, output, _ = run("optimize", "tell", "--state", state, *("--value", "0.3,12") * 4)
    assert code == 0
    assert "batch-2-gait-01" in output


def test_tank_and_model_take_the_same_course(run: Run, state: str) -> None:
    """A tank that swims like the model leads the optimizer to the same gait, digit for digit."""
    fish = ht.load("hypertuna")
    run("optimize", "ask", "--state", state, *TANK)
    for _ in range(2):
        gaits = strict(run("optimize", "ask", "--state", state, "--json")[1])["gaits"]
        speeds = []
        for gait in gaits:
            amplitude, phase = gait["amplitude_deg"], gait["phase_deg"]
            made = ht.Gait.from_degrees(frequency=gait["frequency_hz"], amplitude=amplitude, phase=phase)
            speeds += ["--value", f"{ht.swim(fish, made).speed:.12f}"]
        told = strict(run("optimize", "tell", "--state", state, *speeds, "--json")[1])
    model = optimize(fish, maximize="speed", method="pso", particles=4, iterations=2)
    assert model.gait is not None
    assert told["best"]["gait"]["frequency_hz"] == pytest.approx(model.gait.frequency, rel=1e-9)
    assert told["best"]["speed_m_s"] == pytest.approx(model.speed, rel=1e-9)
