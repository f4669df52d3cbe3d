"""Mistakes in files and folders, written down before their answers: one sentence each, with the fix in it."""

import shutil
from pathlib import Path

import pytest

from hypertuna.actuation.new import first_robot
from program import Run

REPOSITORY = Path(__file__).parents[2]

# What is typed behind `hypertuna` in the folder below, and the answer behind "error: ".
SENSORS = "[[sensors]] for rate, acceleration, depth, field, position"
AT_SEA = (
    "copy them, [gaits] and their lines of [sources] from a robot of this size; `hypertuna robot new own-sea.toml "
    "--lengths 0.15,0.075,0.075 --mass 0.54 --joints J1,J2 --actuation servo --sea` writes it."
)
MISTAKES = {
    "robot chekc own.toml": "chekc is not a command of `hypertuna robot`: did you mean check?",
    "robot check box.toml": "box.toml is a mission, not a robot: `hypertuna mission box.toml` flies it.",
    "robot check tank.csv": "tank.csv is not a robot: give a robot's name or the path of its TOML file.",
    "robot check .": ". is a folder: give the path of a TOML file.",
    "swim --robot tank.toml": "tank.toml is a manifest of trials, not a robot: `hypertuna identify tank.toml` reads "
    "it.",
    "swim --robot .": ". is a folder: give the path of a TOML file.",
    "swim --robot own.toml --gait optimised-0.3": "own.toml: gait must be a gait of the robot, but is "
    "'optimised-0.3': use one of cruise.",
    "optimize tell tank.csv --state search.json": "search.json does not exist: start one, for example `hypertuna"
    " optimize ask --state search.json --robot fish.toml --maximize speed`.",
    "identify runs.csv": "runs.csv must be a file, but is missing: check the path.",
    "identify semicolon.csv": "semicolon.csv must be separated by commas, but is separated by semicolons: save it "
    "with commas, and decimal points in numbers.",
    "identify tank.xlsx": "tank.xlsx must be a CSV file of steady runs, a TOML manifest, a .mcap log or a folder: "
    "save the table as CSV, with commas between the cells.",
    "trials check swim.MP4": "swim.MP4 must be a CSV file of steady runs, a TOML manifest, a .mcap log or a folder: "
    "track the robot through the film: `hypertuna trials track`.",
    "identify tank.csv --robot rexeel": "tank.csv: line 2, amplitude_I_deg, amplitude_II_deg, phase_II_deg are not "
    "known columns: in KIND_GROUP_deg, GROUP is a joint group of rexeel by name or number (1, 2, 3, 4, 5); choose "
    "the robot that swam with --robot: did you mean amplitude_5_deg?",
    "identify plain.csv": "plain.csv has 6 mistakes:\n"
    "  1. line 1, frequency is not a known column: did you mean frequency_hz?\n"
    "  2. line 1, amplitude is not a known column: in KIND_GROUP_deg, GROUP is a joint group of "
    "hypertuna by name or number (I, II); choose the robot that swam with --robot: did you mean amplitude_I_deg?\n"
    "  3. line 1, phase is not a known column: use one of amplitude_I_deg, amplitude_II_deg, phase_II_deg, "
    "bias_I_deg, bias_II_deg.\n"
    "  4. line 1, speed is not a known column: did you mean speed_m_s?\n"
    "  5. amplitude_II_deg must be a column, but is missing: add it; in KIND_GROUP_deg, GROUP is a joint group of "
    "hypertuna by name or number (I, II).\n"
    "  6. phase_II_deg must be a column, but is missing: add it; in KIND_GROUP_deg, GROUP is a joint group of "
    "hypertuna by name or number (I, II).",
    "identify empty.csv": "empty.csv must be a table, but is empty: give a line of column names, then one line per "
    "sample.",
    "identify tank.csv --free water.dragg": "free water.dragg is not a coefficient that can be free: did you mean "
    "water.drag?",
    "identify tank.csv --validate 20": "validate must be at least 0 and less than 1, but is 20: give a fraction such "
    "as 0.2, or 0 for none.",
    "identify own.toml": "own.toml is a robot, not a manifest of trials: a robot is an option: `--robot own.toml`.",
    "trials check .": ". holds no known published files: give a CSV file, a manifest, or the folder with "
    "*deg_hardware_motor_angles.csv and *deg_hardware_trajectories.csv of "
    "RoboticExplorationLab/RoboticSwimmingWithUnifiedFluidRobot.",
    "trials check poses.csv": "poses.csv has a column of time, so it is not a table of steady runs: tracks of head or "
    "markers belong in a manifest, `[[recordings]]` (trials import markers or poses makes one). One tracked point "
    "gives only a speed: measure it, and write a row of a table of steady runs.",
    "trials check percent.csv": "percent.csv: line 2, speed_cm_s is not a known column: did you mean "
    "speed_m_s? Then divide the numbers by 100.",
    "trials check markers.csv": "markers.csv holds tracked points, in the form of plain columns: `hypertuna trials "
    "import markers markers.csv --robot ROBOT -o markers.toml` makes a manifest of it.",
    "identify labels.csv": "labels.csv holds tracked points, in the form of DeepLabCut: `hypertuna trials import "
    "markers labels.csv --robot ROBOT -o labels.toml` makes a manifest of it.",
    "identify swim.slp": "swim.slp holds tracked points, in the form of SLEAP's labels: `hypertuna trials import "
    "markers swim.slp --robot ROBOT -o swim.toml` makes a manifest of it.",
    "trials import markers poses.csv -o markers.toml": "poses.csv must have at least two markers, but is 1: name "
    "columns of markers x1, y1, x2, y2, ... or nose_x, nose_y, ....",
    "replay angels.csv": "angels.csv must be a file, but is missing: check the path.",
    "replay angles.csv": "--columns is required with a CSV file: name the columns of angles, or give a manifest.",
    "replay angles.csv --columns joint_1,joint_2": "angles.csv: column joint_1 must be a column of the file, but is "
    "missing: did you mean joint_I?",
    "replay angles.csv --columns joint_I,joint_II --unit degrees": "unit must be a known unit, but is 'degrees': did "
    "you mean deg?",
    "replay angles.csv --columns joint_I": "angles.csv: the number of angles must be 2, one per joint group of "
    "hypertuna (I, II), but is 1: name one column of angles per joint group, from head to tail.",
    "joint bend --robot own.toml --joint J1": "own.toml: drive_unit is missing: add the table [drive_unit].",
    "joint fit tank.csv": "tank.csv: line 2, frequency_hz, amplitude_I_deg, amplitude_II_deg, phase_II_deg, "
    "speed_m_s, speed_sd_m_s, cost_of_transport_j_per_kg_m, cost_of_transport_sd_j_per_kg_m, repeats are not known "
    "columns: known ones are joint, side, pressure_kpa, branch, run, angle_deg, angle_sd_deg, volume_ml, "
    "volume_sd_ml, shortening_mm, shortening_sd_mm, moment_n_m, moment_sd_n_m, force_n, force_sd_n, arm_mm.",
    "joint family tank.csv": "tank.csv: line 2, frequency_hz, amplitude_I_deg, amplitude_II_deg, phase_II_deg, "
    "speed_m_s, speed_sd_m_s, cost_of_transport_j_per_kg_m, cost_of_transport_sd_j_per_kg_m, repeats are not known "
    "columns: known ones are joint, side, pressure_kpa, branch, run, angle_deg, angle_sd_deg, volume_ml, "
    "volume_sd_ml, shortening_mm, shortening_sd_mm, moment_n_m, moment_sd_n_m, force_n, force_sd_n, arm_mm.",
    "joint silicone tank.csv": "tank.csv must have a row of names with Engineering Strain and Engineering Stress "
    "(MPa): add it above the numbers; True Strain and True Stress are accepted, too.",
    "pump --robot own.toml": "own.toml: pump is missing: add the table [pump].",
    "twin --robot own.toml": "own.toml: controller is missing: copy it and the drives of [[joints]] from a robot of "
    "this size; `hypertuna robot new own-twin.toml --lengths 0.15,0.075,0.075 --mass 0.54 --joints J1,J2 --actuation "
    "servo` writes one.",
    "mission tank.toml": "tank.toml is a manifest of trials, not a mission: `hypertuna identify tank.toml` reads it.",
    "mission box --robot own.toml": "own.toml: [battery], [controller], [spatial], [fins], [guidance], "
    f"{SENSORS} are missing: {AT_SEA}",
    "log info flight.mcap": "flight.mcap must be a file, but is missing: give the path of a .mcap file.",
    "log info tank.csv": "tank.csv must be an MCAP file, but is something else: give a .mcap file.",
    "firmware params --robot own.toml": "own.toml: [battery], [controller], [guidance], [firmware], "
    f"{SENSORS} are missing: {AT_SEA}",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as users have it: trials of HyperTuna, tables of a spreadsheet, a mission, an own robot."""
    folder = tmp_path_factory.mktemp("mine")
    for name in ("tank.csv", "tank.toml", "angles.csv", "poses.csv"):
        shutil.copy(REPOSITORY / "examples" / "tank" / name, folder)
    shutil.copy(REPOSITORY / "missions" / "box.toml", folder)
    (folder / "own.toml").write_text(first_robot("own"))
    text = (folder / "tank.csv").read_text()
    (folder / "semicolon.csv").write_text(text.replace(",", ";").replace(".", ","))
    (folder / "bom.csv").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    (folder / "tank.xlsx").write_bytes(b"PK\x03\x04")
    (folder / "swim.MP4").write_bytes(b"\0\0\0 ftypisom")
    (folder / "plain.csv").write_text("frequency,amplitude,phase,speed\n1,16,0,0.3\n")
    (folder / "empty.csv").write_text("")
    rows = "".join(f"{k / 30:.4f},{k},0,{k + 9},0\n" for k in range(20))
    (folder / "markers.csv").write_text(f"time_s,a_x,a_y,b_x,b_y\n{rows}")
    (folder / "labels.csv").write_text(f"scorer,n,n,n,n\nbodyparts,a,a,b,b\ncoords,x,y,x,y\n{rows}")
    (folder / "swim.slp").write_bytes(b"\x89HDF")
    (folder / "percent.csv").write_text(text.replace("speed_m_s", "speed_cm_s"))
    return folder


@pytest.mark.parametrize("typed", MISTAKES)
def test_a_mistaken_file_has_one_sentence_with_the_fix(
    typed: str, folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("HYPERTUNA_ROBOT", raising=False)
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    assert run(*typed.split()) == (2, "", f"error: {MISTAKES[typed]}\n")
    assert sorted(folder.iterdir()) == before


def test_a_table_of_excel_is_read(folder: Path, run: Run) -> None:
    told = [run("trials", "check", str(folder / f"{name}.csv"))[1].split(":", 1)[1] for name in ("bom", "tank")]
    assert told[0] == told[1]


def test_values_may_have_spaces_behind_commas(run: Run) -> None:
    plain = run("swim", "--frequency", "2", "--amplitude", "16,25", "--phase", "0,40")
    assert run("swim", "--frequency", "2", "--amplitude", "16, 25", "--phase", "0, 40") == plain


def test_amplitudes_in_radians_are_told(run: Run) -> None:
    code, _, errors = run("swim", "--frequency", "2", "--amplitude", "0.28,0.44", "--phase", "0,0.7")
    assert code == 0
    assert errors == "note: amplitudes are in degrees, and these are small; multiply radians by 57.3.\n"
    assert run("swim", "--frequency", "2", "--amplitude", "0,0.44", "--phase", "0,0")[2].startswith("note: amplitudes")
    assert run("swim", "--frequency", "2", "--amplitude", "0,16", "--phase", "0,40")[2] == ""
