"""The commands `hypertuna log`, and the figure of a mission."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.cli.main import main
from hypertuna.mission.plots import plot_mission
from hypertuna.mission.record import MissionRecord
from voyage import voyage

pytest.importorskip("foxglove", reason="needs the extra log")
from mcap.reader import make_reader

from hypertuna.mission.log import write_log

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `hypertuna` with arguments: exit code, output, errors."""
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hypertuna", *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        return int(exit_.value.code or 0), *capsys.readouterr()

    return call


@pytest.fixture(scope="module")
def record() -> MissionRecord:
    return voyage(60, 10)


@pytest.fixture(scope="module")
def file(record: MissionRecord, tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(write_log(record, tmp_path_factory.mktemp("log") / "run.mcap"))


def test_info_tells_the_mission(run: Run, file: str, record: MissionRecord) -> None:
    code, output, _ = run("log", "info", file, "--json")
    told = json.loads(output)
    assert code == 0
    assert (told["mission"], told["robot"], told["times"], told["complete"]) == ("box", "hypertuna", 600, True)
    assert told["distance_m"] == pytest.approx(record.distance)
    assert told["energy_wh"] == pytest.approx(record.energy[-1] / 3600)
    off = record.data["position_estimated"] - record.data["position"][:, :2]
    assert told["estimation_error_max_m"] == pytest.approx(np.hypot(*off.T).max())
    assert told["mode_at_end"] == "surface"
    assert told["facts"]["seed"] == "1"
    code, output, _ = run("log", "info", file)
    assert f"{record.distance:.4g}" in output
    assert "all checksums are right" in output


def test_info_counts_the_messages_of_a_radio_log(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("pymavlink", reason="the radio needs the extra radio")
    from tank_log import bench_test

    path = tmp_path / "bench.mcap"
    bench_test(path, ht.load("hypertuna"))
    code, output, _ = run("log", "info", str(path), "--json")
    told = json.loads(output)
    assert (code, told["messages"], told["complete"]) == (0, {"HYDRAULICS": 802}, True)
    assert told["seconds"] == pytest.approx(90)
    assert "802 HYDRAULICS" in run("log", "info", str(path))[1]
    path.write_bytes(path.read_bytes()[:-300])
    assert run("log", "info", str(path))[0] == 1
    assert "identify" in run("log", "plot", str(path), "-o", str(tmp_path / "plot.svg"))[2]


def test_a_radio_log_whose_head_is_no_table_is_refused(run: Run, tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "head.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata("hypertuna", {"link": "1"})
        writer.finish()
    code, _, error = run("log", "info", str(path))
    assert code == 2
    assert "must have messages in hypertuna's format" in error


def test_a_log_that_was_cut_is_told_with_exit_code_1(run: Run, file: str, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(Path(file).read_bytes()[: Path(file).stat().st_size // 2])
    code, output, _ = run("log", "info", str(cut), "--json")
    told = json.loads(output)
    assert code == 1
    assert not told["complete"]
    assert "cut short" in told["status_text"]
    assert 0 < told["times"] < 600
    code, output, errors = run("log", "to-csv", str(cut), "-o", str(tmp_path / "cut.csv"))
    assert code == 0
    assert "cut short" in errors


def test_files_of_a_log(run: Run, file: str, record: MissionRecord, tmp_path: Path) -> None:
    table, track, plot = (str(tmp_path / name) for name in ("run.csv", "run.gpx", "run.svg"))
    assert run("log", "to-csv", file, "-o", table) == (0, f"written: {table}\n", "")
    rows = np.genfromtxt(table, delimiter=",", names=True)
    np.testing.assert_allclose(rows["time_s"], record.time, rtol=1e-8)
    np.testing.assert_allclose(rows["depth_m"], record.depth, atol=1e-8)
    np.testing.assert_allclose(rows["angle_II_deg"], np.degrees(record.data["angle"][:, 1]), rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(rows["unit_pressure_I_left_kpa"], record.data["unit_pressure"][:, 0] / 1e3, rtol=1e-8)
    assert json.loads(run("log", "to-gpx", file, "-o", track, "--json")[1])["written"] == track
    assert Path(track).read_text().count("<trk>") == 2
    assert run("log", "plot", file, "-o", plot)[0] == 0
    assert "estimated" in Path(plot).read_text()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("info", "nowhere.mcap"), "nowhere.mcap must be a file, but is missing"),
        (("plot", "FILE", "-o", "a.gif"), "--output must end in .svg, .png or .pdf"),
        (("to-csv", "FILE", "-o", "a.nc"), "--output must end in .csv"),
        (("to-gpx", "FILE", "-o", "/nowhere/a.gpx"), "must be in a folder that exists"),
        (("to-csv", "FILE"), "`hypertuna log to-csv` needs --output FILE"),
    ],
)
def test_bad_input_is_one_sentence(run: Run, file: str, arguments: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("log", *(file if one == "FILE" else one for one in arguments))
    assert (code, output) == (2, "")
    assert sentence in errors
    assert errors.count("\n") == 1


def test_a_log_without_an_origin_has_no_gpx(run: Run, record: MissionRecord, tmp_path: Path) -> None:
    file = str(write_log(replace(record, origin=None), tmp_path / "run.mcap"))
    code, _, errors = run("log", "to-gpx", file, "-o", str(tmp_path / "a.gpx"))
    assert code == 2
    assert errors.startswith(f"error: {file}: origin is needed")


# --- the figure


@pytest.mark.parametrize("flown", [False, True], ids=["record", "mission"])
def test_a_layout_names_what_its_log_has(run: Run, file: str, flown: bool, tmp_path: Path) -> None:
    log, output = str(tmp_path / "log.mcap") if flown else file, tmp_path / "layout.json"
    if flown:
        run("mission", "box", "--duration", "5", "-o", log)
    assert run("log", "to-layout", log, "-o", str(output))[0] == 0
    layout = json.loads(output.read_text())
    panels = layout["configById"].values()
    paths = {path["value"] for panel in panels for path in panel.get("paths", ())}
    paths |= {panel["topicPath"] for panel in panels if "topicPath" in panel}
    with open(log, "rb") as content:
        messages = [(channel.topic, message.data) for _, channel, message in make_reader(content).iter_messages()]
    topics = {topic for topic, _ in messages}
    first = {topic: json.loads(data) for topic, data in messages[::-1] if data[:1] == b"{"}
    assert paths <= {f"{topic}.{key}" for topic, message in first.items() for key in message}
    assert "/motion.depth_m" in paths
    assert {panel["followTopic"] for panel in panels if "followTopic" in panel} <= topics
    tiles = re.findall(r'"([^"]+![^"]+)"', json.dumps(layout["layout"]))
    assert sorted(tiles) == sorted(layout["configById"])
    if flown:
        assert {"/hydraulics.pump_pressure_I_left_kpa", "/battery.power_w", "/mode.mode_name"} <= paths


@pytest.mark.parametrize("width", [7.2, 3.4])
def test_the_plan_shows_where_it_was_and_believed_to_be(record: MissionRecord, width: float) -> None:
    plan, depth, energy = plot_mission(record, width=width).axes
    lines = {line.get_label(): line for line in plan.lines}
    np.testing.assert_allclose(lines["true"].get_xydata(), record.path[:, :2])
    assert np.hypot(*(lines["estimated"].get_xydata()[-1] - lines["true"].get_xydata()[-1])) > 0.5
    assert len(plan.patches) == 1 + 4  # fence, waypoints
    assert plan.get_aspect() == 1
    assert depth.yaxis_inverted()
    np.testing.assert_allclose(depth.lines[0].get_ydata(), record.depth)
    assert {line.get_label() for line in depth.lines} >= {"depth limit"}
    assert energy.lines[0].get_ydata()[-1] == pytest.approx(record.energy[-1] / 3600)
    assert {patch.get_label() for patch in depth.patches} == {"mode: surface"}


def test_a_bare_record_has_a_figure() -> None:
    plan, depth = plot_mission(voyage(5, bare=True)).axes  # no energy is known: no panel of it
    assert "estimated" not in {line.get_label() for line in plan.lines}
    assert not depth.patches


def test_the_figure_tells_the_charge_left(record: MissionRecord) -> None:
    texts = [text.get_text() for text in plot_mission(record).axes[2].texts]
    assert texts == [f"charge left: {100 * record.data['charge_left'][-1]:.0f} %"]
