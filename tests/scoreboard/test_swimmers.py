"""Files of published swimmers: every number has a source, and what a stranger's file can hold is bounded."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomlkit

from hypertuna.errors import InputError
from hypertuna.io.door import KINDS
from hypertuna.io.files import shipped
from hypertuna.scoreboard.fits import other_speeds
from hypertuna.scoreboard.prediction import first_robot, own_robot
from hypertuna.scoreboard.scoreboard import score_swimmers
from hypertuna.scoreboard.swimmers import FOLDER, read_swimmer, swimmers

FISH: dict[str, Any] = {
    "name": "Fish",
    "reference": "a paper",
    "nose": "robot",
    "links": 3,
    "body": {"length_m": 0.3, "mass_kg": 0.85, "height_m": 0.06},
    "fin": {"span_m": 0.08, "chord_m": 0.04},
    "runs": [
        {"name": "slow", "frequency_hz": 1.0, "speed_m_s": 0.1, "excursion_m": 0.05},
        {"name": "fast", "frequency_hz": 2.0, "speed_m_s": 0.2, "speed_error": 0.05, "amplitude_deg": [10.0, 20.0]},
        {"name": "held", "frequency_hz": 2.0, "speed_m_s": 0.0, "thrust_n": 0.1, "power_w": 2.0, "power": "electrical"},
    ],
    "sources": {
        "nose": "photo",
        "links": "photo",
        "body.length_m": "Table 1",
        "body.mass_kg": "Table 1",
        "body.height_m": "estimate: photo",
        "fin": "Table 1",
        "runs.frequency_hz": "Table 2",
        "runs.speed_m_s": "Table 2",
        "runs.speed_error": "Table 2",
        "runs.excursion_m": "Fig. 3",
        "runs.amplitude_deg": "Fig. 3",
        "runs.thrust_n": "Fig. 4",
        "runs.power_w": "Fig. 4",
    },
}


def written(document: dict[str, Any], folder: Path) -> Path:
    path = folder / "fish.toml"
    path.write_text(tomlkit.dumps(document))
    return path


def refused(document: dict[str, Any], folder: Path) -> str:
    with pytest.raises(InputError) as error:
        read_swimmer(written(document, folder))
    assert str(folder / "fish.toml") in str(error.value)
    return str(error.value)


def changed(**changes: Any) -> dict[str, Any]:
    return copy.deepcopy(FISH) | changes


def run(**changes: Any) -> list[dict[str, Any]]:
    return [{"name": "one", "frequency_hz": 1.0, "speed_m_s": 0.1} | changes]


@pytest.mark.parametrize("name", swimmers())
def test_every_swimmer_that_ships_has_a_source_for_each_number(name: str) -> None:
    swimmer = read_swimmer(name)
    document = tomllib.loads((shipped(FOLDER) / f"{name}.toml").read_text())
    assert swimmer.name == document["name"]
    assert all(run.published > 0 for run in swimmer.runs)


def test_values_are_read_in_si_units(tmp_path: Path) -> None:
    swimmer = read_swimmer(written(FISH, tmp_path))
    assert swimmer.link_count == 3
    assert swimmer.lengths == ()
    assert swimmer.runs[1].amplitude == pytest.approx((0.17453293, 0.34906585))
    assert [run.published for run in swimmer.runs] == [0.1, 0.2, 0.1]


@pytest.mark.parametrize("key", FISH["sources"])
def test_a_number_without_a_source_is_refused_by_its_key(key: str, tmp_path: Path) -> None:
    rest = {name: text for name, text in FISH["sources"].items() if name != key}
    sentence = refused(changed(sources=rest), tmp_path)
    assert f"{key}" in sentence
    assert "must have a source" in sentence
    assert "[sources]" in sentence


def test_a_source_of_nothing_is_refused(tmp_path: Path) -> None:
    sentence = refused(changed(sources=FISH["sources"] | {"body.hight_m": "x"}), tmp_path)
    assert 'sources."body.hight_m" must be a key with a value: did you mean body.height_m?' in sentence


def test_the_start_of_a_key_is_a_source_of_all_below_it(tmp_path: Path) -> None:
    sources = {"nose": "photo", "links": "photo", "body": "Table 1", "fin": "Table 1", "runs": "Table 2"}
    assert read_swimmer(written(changed(sources=sources), tmp_path)).body.height == 0.06


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"links": 1}, "links must be from 2 to 20, but is 1"),
        ({"links": {"length_m": [0.1, 0.1]}}, "links.length_m must add up to body.length_m within 1 %, but is 0.2 m"),
        ({"links": {"length_m": [0.01] * 21}}, "links"),
        ({"nose": "sharp"}, "nose must be 'streamlined', 'robot' or 'blunt'"),
        ({"runs": []}, "runs must not be empty"),
        ({"runs": run() * 101}, "runs"),
        ({"runs": run() * 2}, "runs[1].name must be unique"),
        ({"runs": run(speed_m_s=0.0)}, "must be above 0, or be 0 beside thrust_n"),
        ({"runs": run(thrust_n=0.1)}, "must be above 0, or be 0 beside thrust_n"),
        ({"runs": run(power_w=1.0)}, "must stand beside power_w"),
        ({"runs": run(speed_error=2.0)}, "speed_error must be at most 1"),
        ({"runs": run(frequency_hz=float("nan"))}, "frequency_hz must be a finite number"),
        ({"runs": run(amplitude_deg=[10.0])}, "runs[0].amplitude_deg must be 2 long, one value per joint group"),
        ({"joints": ["tail"], "runs": run(phase_deg=[0.0, 1.0])}, "runs[0].phase_deg must be 1 long"),
        ({"body": {"lenght_m": 0.3}}, "did you mean length_m?"),
    ],
)
def test_a_mistake_is_one_sentence_with_key_and_rule(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    assert words in refused(changed(**changes), tmp_path)


def test_a_file_is_bounded_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "fish.toml"
    path.write_text("#" * (KINDS["toml"].largest + 1))
    with pytest.raises(InputError, match=r"must be at most 1 MB"):
        read_swimmer(path)


def test_unknown_swimmers_and_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="did you mean tunabot"):
        read_swimmer("tunabott")
    with pytest.raises(InputError, match="must be a file, but is missing"):
        read_swimmer(tmp_path / "none.toml")


def test_speeds_are_predicted_from_one_another_by_published_sections_and_else_by_the_first_robot(
    tmp_path: Path,
) -> None:
    sizes = {key: FISH["body"][key] for key in ("length_m", "mass_kg")}
    sources = {key: text for key, text in FISH["sources"].items() if key not in ("body.height_m", "fin")}
    bare = {key: value for key, value in changed(body=sizes, sources=sources).items() if key != "fin"}
    for document, robot_of, other_of in ((FISH, own_robot, first_robot), (bare, first_robot, own_robot)):
        fish = read_swimmer(written(document, tmp_path))
        robot, other = robot_of(fish), other_of(fish)
        assert robot is not None
        found = score_swimmers([tmp_path / "fish.toml"]).others["Fish"]
        assert found == other_speeds(robot, fish.runs)
        assert other is None or found != other_speeds(other, fish.runs)
