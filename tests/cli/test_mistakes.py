"""Mistakes on the command line, written down before their answers: one sentence each, with the fix in it."""

from pathlib import Path

import pytest

from program import Run

GAITS = "unoptimised-max, unoptimised-0.3, unoptimised-0.4, unoptimised-0.5, optimised-max, optimised-0.3, "
GAITS += "optimised-0.4, optimised-0.5, turning"
REST = "--amplitude 16,25 --phase 0,40"
SWIM = "swim --gait optimised-0.3"
RANGE = "write a range as START:STOP:COUNT, such as 1:6:6 for 1, 2, 3, 4, 5 and 6"

# What is typed behind `hypertuna`, and the answer behind "error: ".
MISTAKES = {
    "swm": "swm is not a command of `hypertuna`: did you mean swim?",
    "help swm": "swm is not a command of `hypertuna`: did you mean swim?",
    "-robot hypertuna swim": "-robot is not an option of `hypertuna`: write options after a command, such as "
    "`hypertuna swim --robot ...`.",
    "swim -robot hypertuna": "-robot is not an option of `hypertuna swim`: did you mean --robot?",
    "swim -gait=turning": "-gait=turning is not an option of `hypertuna swim`: did you mean --gait=turning?",
    "swim -rob hypertuna": "-rob is not an option of `hypertuna swim`: did you mean --robot?",
    "swim -output fish.nc": "-output is not an option of `hypertuna swim`: did you mean --output?",
    "swim -x 3": "-x is not an option of `hypertuna swim`: `hypertuna swim --help` lists the options.",
    f"{SWIM} --plot": "--plot needs a value: write --plot FILE.",
    f"{SWIM} --plot --json": "--plot needs a value: write --plot FILE.",
    f"{SWIM} --plot -o swim.nc": "--plot needs a value: write --plot FILE.",
    f"{SWIM} --plot=": "--plot needs the name of a file: write --plot NAME.svg.",
    "swim --gait --frequency 2": "--gait needs a value: write --gait NAME.",
    "optimize --maximize --speed 3": "--maximize needs a value: write --maximize NAME.",
    "joint bnd": "bnd is not a command of `hypertuna joint`: did you mean bend?",
    "--robot hypertuna swim": "--robot is not an option of `hypertuna`: write options after a command, such as "
    "`hypertuna swim --robot ...`.",
    "swim": "--frequency, --amplitude and --phase are missing: give them, or --gait with one of " + GAITS + ".",
    "swim --frequency 2": "--amplitude and --phase are missing: give them, or --gait with one of " + GAITS + ".",
    "sweep --frequency 1:6:6 --amplitude 16,25": "--phase is missing: give it, or --gait with one of " + GAITS + ".",
    "swim --gait fast": "robots/hypertuna.toml: gait must be a gait of the robot, but is 'fast': use one of "
    + GAITS
    + ".",
    f"{SWIM} --robot hypertunna": "robots/hypertunna.toml does not exist: did you mean hypertuna?",
    f"{SWIM} --robot mine.toml": "mine.toml does not exist: give a robot's name or the path of its TOML file.",
    f"{SWIM} --robot": "--robot needs a value: write --robot ROBOT.",
    f"{SWIM} hypertuna": "hypertuna is not expected here: give the robot as an option, "
    "`hypertuna swim --robot hypertuna`.",
    f"{SWIM} fast": "fast is not expected here: leave it out, or see `hypertuna swim --help`.",
    f"{SWIM} --freq 3": "--freq is not an option of `hypertuna swim`: did you mean --frequency?",
    f"{SWIM} --watr strip": "--watr is not an option of `hypertuna swim`: did you mean --water?",
    f"{SWIM} --radius 2": "--radius is not an option of `hypertuna swim`: `hypertuna swim --help` lists the options.",
    f"{SWIM} --json=yes": "--json takes no value: write --json alone.",
    f"{SWIM} --water stripe": "--water must be lumped, strip or elongated, but is 'stripe': did you mean strip?",
    f"{SWIM} --joints idael": "--joints must be ideal or bandwidth, but is 'idael': did you mean ideal?",
    f"{SWIM} -o out.txt": "--output must end in .nc, but is 'out.txt': write out.nc.",
    f"{SWIM} -o nowhere/out.nc": "--output must be in a folder that exists, but is 'nowhere/out.nc': make the folder "
    "first.",
    f"{SWIM} --plot fish.jpg": "--plot must end in .svg, .png, .pdf or .gif, but is 'fish.jpg': write fish.svg.",
    f"{SWIM} --from-rest 10s": "--from-rest must be a number, but is '10s': give the number alone, in seconds.",
    f"{SWIM} --steps 3.5": "--steps must be a whole number, but is '3.5': write digits only.",
    f"{SWIM} --current 0.1": "--current must be 2 numbers, but is 0.1: give them in m/s, separated by commas.",
    f"swim --frequency 2Hz {REST}": "--frequency must be a number, but is '2Hz': give the number alone, in Hz.",
    f"swim --frequency two {REST}": "--frequency must be a number, but is 'two': give it in Hz.",
    f"swim --frequency 2,5 {REST}": "--frequency must be a single value, but is 2 and 5: give one, with a decimal "
    "point; `hypertuna sweep` swims several.",
    f"swim --frequency 1:4:4 {REST}": "--frequency must be a single value, but is 1 and 2 and 2 more: give one, with a "
    "decimal point; `hypertuna sweep` swims several.",
    f"swim --frequency -2 {REST}": "--frequency must be greater than 0, but is -2: give it in Hz.",
    "swim --frequency 2 --amplitude 16 --phase 0,40": "--amplitude must be 2 values, for joint groups I, II, but has 1 "
    "(16): give 2, separated by commas.",
    "swim --frequency 2 --amplitude 16 25 --phase 0,40": "25 is not expected here: separate the values of an option "
    "by commas, without spaces, such as --amplitude 16,25.",
    "swim --frequency 2 --amplitude 16,25 --phase 0°,40°": "--phase[0] must be a number, but is '0°': give the number "
    "alone, in degrees.",
    f"sweep --frequency 2:6 {REST}": "--frequency must be a number or start:stop:count, but is '2:6': write, for "
    "example, 1:6:6 for 1, 2, 3, 4, 5 and 6.",
    f"sweep --frequency 2-6 {REST}": "--frequency must be a number, but is '2-6': " + RANGE + ".",
    f"sweep --frequency 2:6:1.5 {REST}": "--frequency's count must be a whole number, but is '1.5': write digits only.",
    f"sweep --frequency 2:6:100000 {REST} --amplitude 1:16:100,25": "the number of gaits must be at most 10000000, but "
    "is 10100000: take fewer values, or write shards, -o NAME.shards.",
    "twin --gait optimised-0.3 --duration 1min": "--duration must be a number, but is '1min': give the number "
    "alone, in seconds.",
    "twin --gait optimised-0.3 --duration 0": "--duration must be at least two beats, 0.939 s at 2.13 Hz, but is 0 s: "
    "give at least 0.94; 20 beats or more let the robot settle.",
    "twin --gait optimised-0.3 --medium oil": "--medium must be water or air, but is 'oil': use one of water, air.",
    "joint bend": "`hypertuna joint bend` needs --joint JOINT (name of the joint group, or its number from the head).",
    "joint bend --joint I --side up": "--side must be left or right, but is 'up': use one of left, right.",
    "joint bend --joint I --pressure 0-250": "--pressure must be a number, but is '0-250': " + RANGE + ".",
    "optimize": "the objective must be one of --maximize, --minimize and --speed, but is missing: give --maximize "
    "speed, --speed 0.4 or --minimize cost_of_transport.",
    "optimize --maximize sped": "objective must be a quantity to optimize, but is 'sped': did you mean speed?",
    "optimize --maximize speed --method sgd": "--method must be gradient, pso, cma or de, but is 'sgd': use one of "
    "gradient, pso, cma, de.",
    "optimize --maximize speed --bounds frequency_hz=1": "--bounds frequency_hz must be LOW:HIGH, but is '1': give two "
    "numbers in Hz or degrees.",
    "identify": "`hypertuna identify` needs TRIALS (CSV files of steady runs, TOML manifests of recordings, or "
    "published folders).",
    "mission moon": "mission must be a .toml file or a mission that comes with hypertuna, but is 'moon': use one of "
    "box, lake, transect.",
    "range": "range needs a gait, or power and speed: give --gait NAME, or --frequency and --amplitude, or --power and "
    "--speed.",
    "radio log": "`hypertuna radio log` needs --connect PLACE (udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or "
    "serial:/dev/ttyUSB0:9600) and --output FILE (write the log to this .mcap file).",
    "hil --board esp": "--board must be pc or qemu, but is 'esp': use one of pc, qemu.",
    f"{SWIM} --set body.mass_kg": "--set must be KEY=VALUE, but is body.mass_kg: write it as KEY=VALUE.",
    f"{SWIM} --set body.mas_kg=3": "--set: body.mas_kg is not a known key: did you mean mass_kg?",
    f"{SWIM} --set joints.III.bandwidth_hz=3": "--set: joints.III.bandwidth_hz names none of the list: did you "
    "mean II?",
    f"{SWIM} --set links.mass_kg[30]=3": "--set: links.mass_kg[30] is beyond the end of the list: indices are from "
    "0 to 7.",
    "robot new": "`hypertuna robot new` needs FILE.toml (file to write; its name is the robot's).",
    "robot new myfish": "FILE must end in .toml, but is 'myfish': write myfish.toml.",
    "robot new fish.toml --length 300": "--length must be from 0.03 to 10 m, but is 300: give the length of the robot"
    " in m.",
    "robot new fish.toml --length 30cm": "--length must be a number, but is '30cm': give the number alone, in m.",
    "robot new fish.toml --mass 850": "--mass must make a fish from 0.03 to 0.45 times as high as long at neutral "
    "buoyancy, but is 850 kg, 11 times as high: a robot of 0.3 m has about 0.0062 to 1.4 kg.",
    "robot new fish.toml --actuation servos": "--actuation must be none, servo or hydraulic, but is 'servos': did you"
    " mean servo?",
    "robot new fish.toml --links 3,4": "--links must be a whole number, but is '3,4': write digits only.",
    "robot new fish.toml --links 1": "--links must be from 2 to 20, but is 1: a head, and one link behind each joint.",
    "robot new fish.toml --joints 2": "--joints must be names of joint groups, but is 2: name them, such as "
    "front,rear; their number follows from --links.",
    "robot show": "`hypertuna robot show` needs ROBOT (name of a robot that comes with hypertuna, or path of a TOML "
    "file).",
    "swim --robot rexeel --gait cruise": "robots/rexeel.toml: gait must be a gait of the robot, but is 'cruise': use "
    "one of wave-10, wave-30.",
    "swim --frequency 2 --amplitude 16;25 --phase 0;40": "--amplitude must be a number, but is '16;25': separate "
    "values with commas, and write decimal points.",
    "swim --frequency 2 --amplitude [16,25] --phase 0,40": "--amplitude[0] must be a number, but is '[16': write the "
    "values without brackets, such as 16,25.",
    "swim --frequency 2 --amplitude 16,25,30 --phase 0,40,80": "--amplitude must be 2 values, for joint groups I, II,"
    " but has 3 (16, 25, 30): give 2, separated by commas.",
    "swim --gait optimised-0.3 --set body.mass_kg=3,3": "--set: body.mass_kg must be a number, but is [3, 3]: write a"
    " decimal point, 3.3.",
    "swim --gait optimised-0.3 --set joints.I.bandwidth_hz=fast": "--set: joints[0].bandwidth_hz must be a number, "
    "but is 'fast': give the bandwidth of the first-order lag [Hz].",
    "swim --gait optimised-0.3 --duration 10": "--duration is not an option of `hypertuna swim`: `hypertuna swim "
    "--help` lists the options.",
    "sweep --frequency 1:6:6 --amplitude 16,25 --phase 0,40 -o sweep.xlsx": "--output must end in .nc, .csv or "
    ".shards, but is 'sweep.xlsx': write sweep.csv.",
    "turn --gait turning --bias 10,20,30": "--bias must be 2 values, for joint groups I, II, but has 3 (10, 20, 30): "
    "give 2, separated by commas.",
    "optimise --maximize speed": "optimise is not a command of `hypertuna`: did you mean optimize?",
    "optimize --maximise speed": "--maximise is not an option of `hypertuna optimize`: did you mean --maximize?",
    "optimize --minimize cot": "objective must be a quantity to optimize, but is 'cot': use one of speed, speed_bl, "
    "stride_length, efficiency, mechanical_power, mechanical_power_positive, power_to_water, cost_of_transport, "
    "cost_of_transport_positive, strouhal, tail_excursion, torque_peak and 2 more.",
    "optimize --maximize speed --bounds freq=1:4": "bounds must name a value of a gait, but is 'freq': did you mean "
    "frequency?",
    "optimize --maximize speed --bounds frequency_hz=4:1": "bounds of frequency_hz must have the lower value first, "
    "but is 4:1: exchange the two.",
    "optimize ask --maximize speed": "`hypertuna optimize ask` needs --state FILE (file that stores the search; "
    "created by the first ask).",
    "pareto --objectives speed": "objectives must name two or three different quantities, but is 'speed': take "
    "speed and cost_of_transport, for example.",
    "pareto --max-joint-rate 10rad/s": "--max-joint-rate must be a number, but is '10rad/s': give the number alone, "
    "in deg/s.",
    "trials import markers tracks.csv": "`hypertuna trials import markers` needs --output FILE (write the manifest to"
    " this .toml file).",
    "joint bend --joint III": "joint must be a joint of hypertuna, but is 'III': did you mean II?",
    "joint bend --joint 3": "joint must be a joint of hypertuna, but is '3': use one of I, II.",
    "joint bend --joint II --pressure 250000": "--pressure must be at most 2000, but is 250000: give it in kPa.",
    "pump --bore 0.004": "--bore must be from 1 to 20 mm, but is 0.004: give it in mm.",
    "pump --over joints.I.line.bore=0.003,0.004": "--over: joints[0].line.bore is not a known key: did you mean "
    "bore_m?",
    "range --power 9": "--speed is needed beside --power: give both, or a gait.",
    "range --gait optimised-0.3 --reserve 20": "reserve must be at least 0 and less than 1, but is 20: give the "
    "fraction of the charge to keep, such as 0.1.",
    "twin --gait optimised-0.3 --temperature 293": "temperature must be from -9 to 100 degC, but is 293 degC: L-HM46 "
    "flows above its pour point, and its viscosity is known up to 100 C.",
    "twin --gait optimised-0.3 --fault bend:stuck": "fault must be CHANNEL:KIND@SECONDS, but is 'bend:stuck': write "
    "for example bend-II:stuck@5, or bend-II:stuck@5-8 for a fault that ends.",
    "twin --gait optimised-0.3 --line-bore 0.004": "--line-bore must be from 1 to 20 mm, but is 0.004: give it in mm.",
    "posture-test --angle 20,20,20": "angle must be 2 values, for joint groups I, II, but is 3 long: give one angle "
    "for each.",
    "dive --robot rexeel --gait wave-10": "robots/rexeel.toml: [battery], [controller], [spatial], [fins] are missing: "
    "copy them and their lines of [sources] from a robot of this size; `hypertuna robot new rexeel-sea.toml --lengths "
    "0.12,0.098,0.098,0.098,0.098,0.098 --mass 0.892 --joints 1,2,3,4,5 --actuation servo --sea` writes it.",
    "dive --gait optimised-0.3 --fins 450": "fins must be at most 45 deg, the controller.fin_max_deg, but is 450 deg:"
    " give less.",
    "mission": "`hypertuna mission` needs FILE.toml (mission file, or name of a mission that comes with hypertuna: "
    "box, lake, transect).",
    "mission box --seeds 100": "--seeds must be FROM:TO, but is '100': write, for example, 0:100.",
    "mission box --shard 1/4 -o m.shards": "--shard applies to many flights: add --seeds, such as --seeds 0:100.",
    "mission box -o box.gpx": "--output must end in .mcap, .nc, .csv or .shards, but is 'box.gpx': "
    "write --gpx box.gpx.",
    "firmware params -o params.h": "--output must end in .hpp, but is 'params.h': write params.hpp.",
    "hil --scenario lack": "--scenario is no scenario, but is 'lack': did you mean lake?",
    "radio log --connect 14550 -o log.mcap": "--connect must be the address of a robot, but is '14550': write "
    "udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600.",
    "radio log --connect /dev/ttyUSB0 -o log.mcap": "--connect must be the address of a robot, but is '/dev/ttyUSB0':"
    " write udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/ttyUSB0:9600.",
    "radio params --connect udp:14550 --set gain": "--set must be NAME=VALUE, but is gain: write it as NAME=VALUE.",
    "radio drive": "`hypertuna radio drive` needs --connect PLACE (udp:14550, udpout:HOST:PORT, tcp:HOST:PORT or "
    "serial:/dev/ttyUSB0:9600).",
    "paper -o index.html": "--output must be a folder, but is 'index.html': write index.",
    "-v": "-v is not an option of `hypertuna`: did you mean --version?",
}


@pytest.mark.parametrize("typed", MISTAKES)
def test_a_mistake_has_one_sentence_with_the_fix(
    typed: str, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("HYPERTUNA_ROBOT", raising=False)
    monkeypatch.chdir(tmp_path)
    assert run(*typed.split()) == (2, "", f"error: {MISTAKES[typed]}\n")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("typed", [(), ("swim",), ("robot", "new"), ("joint", "bend"), ("trials", "import", "markers")])
def test_help_shows_the_help_of_a_command(typed: tuple[str, ...], run: Run) -> None:
    assert run("help", *typed) == run(*typed, "--help")
    assert run("help", *typed)[0] == 0


@pytest.mark.parametrize("typed", [(), ("robot",), ("radio",), ("trials", "import")])
def test_a_group_alone_prints_its_help(typed: tuple[str, ...], run: Run) -> None:
    code, output, errors = run(*typed)
    assert (code, output) == (2, "")
    assert errors == run(*typed, "-h")[1]


def test_a_robot_s_own_file_is_not_overwritten(run: Run, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_bytes((Path(__file__).parents[2] / "robots" / "hypertuna.toml").read_bytes())
    before = own.read_bytes()
    code, output, errors = run("optimize", "--robot", str(own), "--maximize", "speed", "-o", f"{tmp_path}/./own.toml")
    assert (code, output) == (2, "")
    assert errors.startswith("error: --output must not be the file that the robot is read from")
    assert own.read_bytes() == before


def test_the_robot_is_that_of_the_environment(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYPERTUNA_ROBOT", "rexeel")
    assert run("swim", "--gait", "wave-10")[1].startswith("rexeel, ")
    assert run("swim", "--robot", "hypertuna", "--gait", "optimised-0.3")[1].startswith("hypertuna, ")
    monkeypatch.delenv("HYPERTUNA_ROBOT")
    assert run("swim", "--gait", "optimised-0.3")[1].startswith("hypertuna, ")
