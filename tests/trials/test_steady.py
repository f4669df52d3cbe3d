"""Files of steady runs, and the errors of bad ones."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.errors import did_you_mean
from hypertuna.io.tables import conversion
from hypertuna.trials.kind_steady import Steady
from hypertuna.trials.steady import MeasuredBend, read_steady
from hypertuna.trials.trials import read_trials
from told import told, tried, write

HEAD = "frequency_hz,amplitude_I_deg,amplitude_II_deg,phase_II_deg,speed_m_s"


def test_steady_runs_in_si_and_radians(tmp_path, tuna):
    head = f"run,{HEAD},bias_I_deg,speed_sd_m_s,cost_of_transport_j_per_kg_m,cost_of_transport_sd_j_per_kg_m,repeats"
    path = write(
        tmp_path / "tank.csv", "# a tank", "", head, "fast,6,16,25,40,0.58,90,0.01,2.5,0.1,3", ",2,9,18,0,,0,,1.5,,"
    )
    fast, slow = read_steady(path, tuna)
    assert fast.name == "fast"
    assert fast.gait == ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40), bias=(90, 0))
    assert fast.gait.bias[0] == pytest.approx(math.pi / 2)
    assert (fast.speed, fast.speed_sd, fast.cost_of_transport, fast.cost_of_transport_sd) == (0.58, 0.01, 2.5, 0.1)
    assert (fast.repeats, fast.line, fast.file) == (3, 4, str(path))
    assert (slow.name, slow.speed, slow.cost_of_transport, slow.repeats) == ("tank.csv:5", None, 1.5, 1)


@pytest.mark.parametrize(
    "content",
    [
        f"{HEAD}\r\n6,16,25,40,0.58\r\n",
        f"\ufeff{HEAD}\n6,16,25,40,0.58",
        f" {HEAD.replace(',', ' , ')}\n 6, 16 ,25,40,0.58\n\n# the end\n",
        f'"{HEAD.replace(",", chr(34) + "," + chr(34))}"\n6,16,25,40,0.58\n',
        "speed_m_s,phase_2_deg,amplitude_2_deg,amplitude_1_deg,frequency_hz\n0.58,40,25,16,6\n",
    ],
    ids=["CRLF", "BOM", "spaces", "quoted", "by number in any order"],
)
def test_the_same_run_however_it_is_written(tmp_path, tuna, content):
    path = tmp_path / "tank.csv"
    path.write_bytes(content.encode())
    (run,) = read_steady(path, tuna)
    assert run.gait == ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
    assert run.speed == 0.58


def test_names_of_joint_groups_win_over_their_numbers(tmp_path, tuna):
    document = tuna.document()
    for group, name in zip(document["joints"], "21", strict=True):
        group["name"] = name
    swapped = parse(document)
    head = "frequency_hz,amplitude_1_deg,amplitude_2_deg,phase_1_deg,speed_m_s"
    (run,) = read_steady(write(tmp_path / "tank.csv", head, "6,25,16,40,0.58"), swapped)
    assert run.gait == ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("x,16,25,40,0.58", "line 3, frequency_hz must be a number, but is 'x': give a number."),
        (",16,25,40,0.58", "line 3, frequency_hz must be a number, but is empty: fill the cell, or remove the line."),
        ("-6,16,25,40,0.58", "line 3, frequency_hz must be greater than 0, but is -6: give it in Hz."),
        ("6,16,-25,40,0.58", "line 3, amplitude_II_deg must not be negative, but is -25: add half a turn to its phase"),
        ("6,16,250,40,0.58", "line 3, amplitude_II_deg must be at most 180 deg, but is 250: check its unit."),
        (
            "6,16,25,inf,0.58",
            "line 3, phase_II_deg must be a finite number, but is inf: give one angle per joint group.",
        ),
        ("6,16,25,40,nan", "line 3, speed_m_s must be a finite number, but is nan: leave it out if it is unknown."),
        (
            "6,16,25,40,",
            "line 3, speed_m_s must be given, or cost_of_transport, or the bend of a hinge: fill in at least one",
        ),
        (
            "6,16,25,40",
            "line 3 must have 5 cells, like the line of names, but is 4 long: complete the line or remove",
        ),
        (
            '6,16,25,40,"0.58',
            "line 3 must be cells separated by commas, but is not (unexpected end of data): close its",
        ),
    ],
)
def test_bad_rows_are_reported_by_line(tmp_path, tuna, row, sentence):
    path = write(tmp_path / "tank.csv", HEAD, "6,16,25,40,0.58", row)
    assert told(read_steady, path, tuna).startswith(f"{path}: {sentence}")


@pytest.mark.parametrize(
    ("columns", "cells", "sentence"),
    [
        ("speed_sd_m_s", "0", "line 3, speed_sd_m_s must be greater than 0, but is 0"),
        ("repeats", "0", "line 3, repeats must be at least 1, but is 0: give the number of swims"),
        ("repeats", "1.5", "line 3, repeats must be a whole number, but is '1.5': write digits only."),
        ("run", "one", "line 3, run must be unique, but is 'one', as in line 2: give each run its own name."),
        (
            "cost_of_transport_j_per_kg_m",
            "-1",
            "line 3, cost_of_transport_j_per_kg_m must be greater than 0, but is -1",
        ),
        (
            "cost_of_transport_sd_j_per_kg_m",
            "0.1",
            "line 3, cost_of_transport_sd_j_per_kg_m needs cost_of_transport, too",
        ),
    ],
)
def test_bad_optional_cells_are_reported(tmp_path, tuna, columns, cells, sentence):
    first = "one" if columns == "run" else "1" if columns == "repeats" else ""
    path = write(tmp_path / "tank.csv", f"{HEAD},{columns}", f"6,16,25,40,0.58,{first}", f"6,16,25,40,0.58,{cells}")
    assert told(read_steady, path, tuna).startswith(f"{path}: {sentence}")


def with_hinges(robot, *links):
    """The robot with passive hinges at the front ends of links."""
    tables = [{"link": link, "stiffness_n_m_per_rad": 0.1, "damping_n_m_s_per_rad": 1e-3} for link in links]
    document = robot.document()
    document["sources"] |= {"hinges": "bench"}
    return parse(document | {"hinges": tables})


BENDS = "bend_amplitude_1_deg,bend_amplitude_1_sd_deg,bend_lag_2_deg,bend_lag_2_sd_deg"


def test_measured_bends_of_hinges(tmp_path, tuna):
    """In degrees, as results of `swim` have them; a run may have these alone, and its summary has their ranges."""
    robot = with_hinges(tuna, 6, 7)
    first, second = read_steady(
        write(tmp_path / "tank.csv", f"{HEAD},{BENDS}", "6,16,25,40,,18,1.8,,", "6,16,25,40,0.5,,,-90,9"), robot
    )
    assert [bend.bend_amplitude for bend in first.bends] == [pytest.approx(math.pi / 10), None]
    assert (first.speed, first.bends[0].bend_amplitude_sd) == (None, pytest.approx(math.pi / 100))
    assert {name: value for name, (_, value, _) in second.measured().items()} == {
        "speed": 0.5,
        "bend_lag_2": pytest.approx(-math.pi / 2),
    }
    summary = Steady().summaries([first, second], robot)[0]
    assert summary["bend_amplitude_1_deg"] == [pytest.approx(18)] * 2
    assert summary["bend_amplitude_2_deg"] is None
    assert second.to_pandas()["bend_lag_2_deg"].tolist() == [pytest.approx(-90)]
    plot = Steady().plot([first, second], width=6)
    assert [axes.get_ylabel() for axes in plot.axes] == ["speed [m/s]", "bend amplitude 1 [deg]", "bend lag 2 [deg]"]


@pytest.mark.parametrize(
    ("hinges", "column", "cell", "sentence"),
    [
        ((), "bend_amplitude_deg", "18", "bend_amplitude_deg is not a known column: hypertuna has no hinge: leave it"),
        ((6,), "amplitude_hinge_deg", "18", "amplitude_hinge_deg is not a known column: measured bends of the hinges"),
        (
            (6,),
            "bend_lag_rad",
            "1",
            "bend_lag_rad is not a known column: did you mean bend_lag_deg? Then multiply the num",
        ),
        ((6,), "amplitude_3_deg", "1", "(I, II); bends of hinges are columns bend_amplitude_deg and bend_lag_deg of"),
        ((6,), "bend_deg", "18", "bend_deg is not a known column: measured bends of the hinges are bend_amplitude_deg"),
        ((6, 7), "bend_lag_2_deg", "400", "bend_lag_2_deg must be from -360 to 360 deg, but is 400"),
        ((6, 7), "bend_amplitude_2_deg", "-3", "bend_amplitude_2_deg must be greater than 0 and at most 180 deg, but"),
        ((6,), "bend_amplitude_sd_deg", "3", "bend_amplitude_sd_deg needs bend_amplitude, too"),
        ((6,), "bend_amplitude_deg", "nan", "bend_amplitude_deg must be a finite number, but is nan"),
    ],
)
def test_bad_bends_of_hinges(tmp_path, tuna, hinges, column, cell, sentence):
    robot = with_hinges(tuna, *hinges) if hinges else tuna
    path = write(tmp_path / "tank.csv", f"{HEAD},{column}", f"6,16,25,40,0.5,{cell}")
    assert sentence in told(read_steady, path, robot)


def test_bends_in_radians_are_doubted(tmp_path, tuna):
    robot = with_hinges(tuna, 7)
    swing = ht.swim(robot, gait := ht.Gait.from_degrees(frequency=3, amplitude=(16, 25), phase=(0, 40))).bends[0]
    run = ht.SteadyRun("a", gait, bends=(MeasuredBend(math.radians(swing.bend_amplitude)),))
    faults, (warning,) = Steady().implausible([run], robot)
    assert not faults
    assert "the measured amplitudes of hinges (bend_amplitude_deg) are 1/57 of those of the model: likely" in warning


def test_many_bad_rows_are_reported_together(tmp_path, tuna):
    path = write(tmp_path / "tank.csv", HEAD, "6,16,25,40,0.58", *["6,x,25,40,0.58"] * 6, "0,16,25,40,0.58")
    assert told(read_steady, path, tuna) == (
        f"{path} has 7 rows that cannot be used: lines 3, 4, 5, 6, 7 and 1 more, amplitude_I_deg must be a number, "
        "but is 'x'; line 9, frequency_hz must be greater than 0, but is 0."
    )


def test_a_table_that_is_half_filled_in_names_its_empty_rows(tmp_path, tuna):
    """As `design ask -o` writes it, with the lines that a spreadsheet leaves below."""
    path = write(tmp_path / "next.csv", HEAD, "6,16,25,40,0.58", *["6,16,25,40,"] * 3, ",,,,", ",,,,")
    assert told(read_steady, path, tuna) == (
        f"{path}: lines 3, 4, 5, speed_m_s must be given, or cost_of_transport, or the bend of a hinge: fill in at "
        "least one of them, or remove the row of a run that is not made yet."
    )


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ([], "must be a table, but is empty"),
        ([HEAD], "must be a table, but is empty"),
        (
            [HEAD.replace(",", ";"), "6;16;25;40;0,58"],
            "must be separated by commas, but is separated by semicolons: save it",
        ),
        (
            [HEAD.replace("speed", "sped"), "6,16,25,40,1"],
            "line 1, sped_m_s is not a known column: did you mean speed_m_s?",
        ),
        (
            [HEAD.replace("_I_", "_Y_"), "6,16,25,40,1"],
            "line 1, amplitude_Y_deg is not a known column: in KIND_GROUP_deg, GROUP is a joint group of hypertuna by "
            "name or number (I, II); choose the robot that swam with --robot: did you mean amplitude_I_deg?",
        ),
        (
            [f"{HEAD},phase_2_deg", "6,16,25,40,1,40"],
            "line 1, phase_2_deg must appear only once, but is phase_II_deg, too",
        ),
        (["frequency_hz,amplitude_I_deg,amplitude_II_deg,speed_m_s", "6,16,25,1"], "phase_II_deg must be a column"),
        (["amplitude_I_deg,amplitude_II_deg,phase_II_deg,speed_m_s", "16,25,0,1"], "frequency_hz must be a column"),
        (
            ["frequency_hz,amplitude_I_deg,amplitude_II_deg,phase_II_deg", "6,16,25,1"],
            "speed_m_s or cost_of_transport_j_per_kg_m must be a column, but is missing: add what was measured.",
        ),
    ],
)
def test_bad_files_are_reported(tmp_path, tuna, lines, sentence):
    path = write(tmp_path / "tank.csv", *lines)
    assert told(read_steady, path, tuna).removeprefix(str(path)).lstrip(": ").startswith(sentence)


def test_what_is_no_text_file_is_reported(tmp_path, tuna):
    (tmp_path / "words.csv").write_bytes("Frequenz;Höhe".encode("latin-1"))
    (tmp_path / "folder.csv").mkdir()
    assert "words.csv must be readable, but is not (UnicodeDecodeError)" in told(
        read_trials, tmp_path / "words.csv", tuna
    )
    assert "folder.csv is a folder: give the path of a CSV file" in told(read_steady, tmp_path / "folder.csv", tuna)
    assert "nowhere.csv must be a file, but is missing" in told(read_trials, tmp_path / "nowhere.csv", tuna)
    assert "nowhere.toml must be a file, but is missing" in told(read_trials, tmp_path / "nowhere.toml", tuna)
    assert "data.xls must be a CSV file of steady runs, a TOML manifest" in told(read_trials, "data.xls", tuna)
    assert "trials must name at least one file" in told(read_trials, [], tuna)


CELLS = st.sampled_from(
    ["6", "16", "0.58", "", "x", "-1", "nan", "1e999", '"', "1;2", "#", "\r", "\0", "é", *HEAD.split(",")]
)
TABLE = st.lists(st.lists(CELLS, max_size=7).map(",".join), max_size=6).map(lambda rows: "\n".join([HEAD, *rows]))


@given(
    content=st.one_of(
        st.binary(max_size=200),
        st.text(max_size=200).map(lambda s: s.encode("utf-8", "replace")),
        TABLE.map(str.encode),
    )
)
def test_any_bytes_are_runs_or_one_sentence(tmp_path_factory, tuna, content):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    runs, sentence = tried(read_steady, path, tuna)
    assert runs or str(path) in sentence
    assert all(math.isfinite(run.speed) and run.gait.frequency > 0 for run in runs or ())


def test_all_bad_columns_are_told_at_once(tmp_path, tuna):
    head = HEAD.replace("speed_m_s", "speed_cm_s").replace("phase_II", "phase").replace("frequency", "freqency")
    with pytest.raises(ht.InputError) as error:
        read_steady(write(tmp_path / "tank.csv", head, "6,16,25,40,58"), tuna)
    told_once = str(error.value)
    assert "tank.csv has 3 mistakes:" in told_once
    assert "speed_cm_s is not a known column: did you mean speed_m_s? Then divide the numbers by 100." in told_once
    assert "did you mean phase_II_deg?" in told_once  # not of the first joint, whose phase is 0
    assert "did you mean frequency_hz?" in told_once


@pytest.mark.parametrize(
    ("column", "near", "text"),
    [
        ("speed_mm_s", "speed_m_s", " Then divide the numbers by 1000"),
        ("pressure_pa", "pressure_kpa", " Then divide the numbers by 1000"),
        ("pressure_bar", "pressure_kpa", " Then multiply the numbers by 100"),
        ("angle_rad", "angle_deg", " Then multiply the numbers by 57.2958"),
        ("sped_m_s", "speed_m_s", ""),
    ],
)
def test_another_unit_has_a_factor(column, near, text):
    assert conversion(column, near) == text


def test_many_names_end_with_how_many_more():
    assert did_you_mean("xyz", map(str, range(10, 30))).endswith("20, 21 and 8 more")


def test_speeds_in_body_lengths_and_powers_are_converted(tmp_path, tuna) -> None:
    """0.5 BL/s are half the length a second; 2 W at that speed are 2/(m v) J/(kg m)."""
    head = HEAD.replace("speed_m_s", "speed_bl_s,speed_sd_bl_s,power_w,power_sd_w")
    (run,) = read_steady(write(tmp_path / "tank.csv", head, "6,16,25,40,0.5,0.01,2,0.1"), tuna)
    speed = 0.5 * tuna.body.length
    assert (run.speed, run.speed_sd) == pytest.approx((speed, 0.01 * tuna.body.length))
    assert (run.cost_of_transport, run.cost_of_transport_sd) == pytest.approx(
        (2 / (tuna.body.mass * speed), 0.1 / (tuna.body.mass * speed))
    )
    both = write(tmp_path / "both.csv", f"{HEAD},speed_bl_s", "6,16,25,40,0.5,0.5")
    assert "speed_bl_s must appear only once, but is speed_m_s, too" in told(read_steady, both, tuna)
    still = write(tmp_path / "still.csv", f"{HEAD},power_w", "6,16,25,40,0,2")
    assert "power_w needs a speed other than 0, too" in told(read_steady, still, tuna)


def test_all_unknown_columns_of_another_table_are_one_answer_with_all_known_names(tmp_path, tuna) -> None:
    text = told(read_steady, write(tmp_path / "a.csv", "depth,mode,note,who", "1,2,3,4"), tuna)
    assert "line 1, depth, mode, note, who are not known columns: known ones are run, frequency_hz, speed_m_s," in text
    assert "bias_II_deg" in text
