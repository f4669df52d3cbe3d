"""From the radio to coefficients: what a log of a tank run and of a bench test tells."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="the radio needs the extra radio")
pytest.importorskip("foxglove", reason="logs need the extra log")

import hypertuna as ht
from hypertuna.characterization.data import read_bench
from hypertuna.errors import InputError
from hypertuna.io.mcap import read_messages
from hypertuna.radio.dialect import dialect, dialect_file
from hypertuna.radio.log import RadioLogWriter, read_radio_log
from models import changed
from tank_log import START, bench_test, gait_message, tank_run


def test_a_tank_run_gives_the_coefficients_back(tmp_path: Path) -> None:
    """The tail fin has 0.8 times the drag described, which is 4 % of speed; identify reads the log, and finds it."""
    fish = ht.load("hypertuna")
    truth = list(fish.water.lumped.drag)  # type: ignore[union-attr]
    truth[7] *= 0.8
    swum = changed(fish, {"water.lumped.drag": truth})
    gaits = [
        ht.Gait.from_degrees(frequency=f, amplitude=a, phase=(0, 30)) for f in (1, 2, 4) for a in ((10, 15), (16, 25))
    ]
    path = tmp_path / "tank.mcap"
    tank_run(path, swum, gaits)
    trials = ht.read_trials(path, fish)
    assert len(trials.steady) == len(gaits)
    for run, gait in zip(trials.steady, gaits, strict=True):
        assert run.gait.frequency == gait.frequency
        assert run.gait.amplitude == pytest.approx(gait.amplitude, abs=1e-4)
        assert run.gait.phase == pytest.approx(gait.phase, abs=1e-4)
        assert run.speed == pytest.approx(ht.swim(swum, gait).speed, rel=0.02)
    fit = ht.identify(fish, trials, free=["water.drag[7]"], seed=1)
    found = np.asarray(fit.robot.water.lumped.drag)  # type: ignore[union-attr]
    assert found[7] == pytest.approx(truth[7], rel=0.06)


def test_a_bench_test_gives_the_rows_of_its_csv(tmp_path: Path) -> None:
    """Up to 200 kPa and down again at 10 kPa/s, each side of joint I: bends away from the pressure, falling or not."""
    fish, path = ht.load("hypertuna"), tmp_path / "bench.mcap"
    bench_test(path, fish)
    bench = read_bench(path, fish)
    assert bench.joints == (0,)
    assert bench.sides(0) == (0, 1)
    assert np.all(np.degrees(bench.angle) == pytest.approx(bench.pressure / 1e4, abs=0.02))
    assert bench.pressure.max() > 190e3
    assert 0.4 < bench.unload.mean() < 0.6
    assert len(bench.angle) > 100


def test_what_lacks_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, fish = tmp_path / "empty.mcap", ht.load("hypertuna")
    gait = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 0))
    with RadioLogWriter(path, fish.name) as log:
        log.write(gait_message(gait, 0.0), START)
    with pytest.raises(InputError, match=r"ATT_POS_MOCAP must have messages"):
        ht.read_trials(path, fish)
    with pytest.raises(InputError, match=r"HYDRAULICS must have messages"):
        read_bench(path, fish)
    assert read_radio_log(path).fields["GAIT"]["frequency"] == 2000
    messages = read_messages(path)
    contents = {topic: [b'{"frequency": 2\x00}'] for topic in messages.contents}
    with monkeypatch.context() as damage:
        damage.setattr("hypertuna.radio.log.read_messages", lambda _: replace(messages, contents=contents))
        with pytest.raises(InputError, match=r"topics must have messages in hypertuna's format"):
            read_radio_log(path)
    whole = path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="must"):
        ht.read_trials(tmp_path / "cut.mcap", fish)
    (tmp_path / "other.mcap").write_bytes(b"nothing of the kind")
    with pytest.raises(InputError, match="must be an MCAP file"):
        ht.read_trials(tmp_path / "other.mcap", fish)


def test_the_dialect_has_the_tables_on_board() -> None:
    """Names and sentences of the enumerations are those of core and firmware, in order: generate.py wrote them."""
    from hypertuna import _core

    source = dialect_file()
    generator = runpy.run_path(str(source.with_name("generate.py")))
    assert generator["enums"]() in source.read_text(), (
        "run `python firmware/mavlink/generate.py firmware/mavlink/hypertuna.xml enums`"
    )
    module = dialect()

    def names(prefix: str) -> list[str]:
        entries = sorted(module.enums[prefix].items())
        return [entry.name.removeprefix(f"{prefix}_").lower() for _, entry in entries if "ENUM_END" not in entry.name]

    assert names("HYPERTUNA_STATE") == [row[0] for row in _core.state_table()]
    assert names("HYPERTUNA_MODE") == [row[0] for row in _core.mode_table()]
    assert names("HYPERTUNA_REASON") == [row[0] for row in _core.reason_table()]
    assert names("HYPERTUNA_CONDITION") == [row[0] for row in _core.condition_table()]
    assert names("HYPERTUNA_FAULT") == [row[0] for row in _core.fault_table()]
