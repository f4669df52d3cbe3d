"""Export a robot as an FMU for co-simulation: its twin, or only its plant, as binaries that need no Python."""

import hashlib
import io
import uuid
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from hypertuna.arguments import checked
from hypertuna.description.at_sea import require_at_sea
from hypertuna.description.robot import Robot, robot_of
from hypertuna.description.twin import require_controller
from hypertuna.errors import InputError
from hypertuna.export.fmu_variables import Variable, variables
from hypertuna.export.xml import Element, add, document
from hypertuna.io.files import shipped, version
from hypertuna.mission.image import robot_image
from hypertuna.ranges import check_choice

BINARIES = "build/fmu"  # folder of the built binaries
SUFFIXES = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}  # of binaries, by operating system
# Folders of binaries: the keys in FMI 3.0, the values in FMI 2.0, which defines none for arm64.
PLATFORMS = {
    "x86_64-linux": "linux64",
    "aarch64-linux": "aarch64-linux",
    "x86_64-windows": "win64",
    "x86_64-darwin": "darwin64",
    "aarch64-darwin": "aarch64-darwin",
}
# By unit as data sets write it: its name in the FMU, and the exponents of its base units.
UNITS: Mapping[str, tuple[str, Mapping[str, int]]] = {
    "s": ("s", {"s": 1}),
    "Hz": ("Hz", {"s": -1}),
    "m": ("m", {"m": 1}),
    "rad": ("rad", {"rad": 1}),
    "m/s": ("m/s", {"m": 1, "s": -1}),
    "m/s^2": ("m/s2", {"m": 1, "s": -2}),
    "m^3/s": ("m3/s", {"m": 3, "s": -1}),
    "rad/s": ("rad/s", {"rad": 1, "s": -1}),
    "N m": ("N.m", {"kg": 1, "m": 2, "s": -2}),
    "Pa": ("Pa", {"kg": 1, "m": -1, "s": -2}),
    "W": ("W", {"kg": 1, "m": 2, "s": -3}),
    "A": ("A", {"A": 1}),
    "C": ("C", {"A": 1, "s": 1}),
    "V": ("V", {"kg": 1, "m": 2, "s": -3, "A": -1}),
}
DEGREE = "57.29577951308232"  # degrees per radian
TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}  # names of types in FMI 2.0 and in FMI 3.0


@checked
def fmu(robot: Robot | str | Path, *, kind: str = "twin", fmi: int = 2, sea: bool = False) -> bytes:
    """Write a robot as a functional mock-up unit (FMU) for co-simulation, for Simulink, OpenModelica, FMPy and others.

    Parameters
    ----------
    robot : Robot, str or Path
        With the tables that `twin` needs; at sea, also those of `twin_at_sea`.
    kind : str
        ``"twin"``: the whole robot, whose inputs are a gait and fins, and at sea the depth and heading for its pilot.
        ``"plant"``: the robot without its controller, whose inputs are servo pulses.
    fmi : int
        Version of the standard, 2 or 3.
    sea : bool
        Whether the robot moves in space, with its pectoral fins; otherwise in the plane.

    Returns
    -------
    bytes
        Content of the file, with the binaries of all platforms that were built; the same arguments give the same bytes.

    Raises
    ------
    InputError
        If the robot lacks a table, an option is out of range, or no binary was built from the sources of now.

    Examples
    --------
    >>> import hypertuna as ht
    >>> content = ht.fmu("hypertuna", kind="plant", fmi=3)  # doctest: +SKIP
    """
    robot = robot_of(robot)
    check_choice(kind, ("twin", "plant"), "kind")
    check_choice(str(fmi), ("2", "3"), "fmi")
    if sea:
        require_at_sea(robot, "battery", "controller", "spatial", "fins", pilot=False)
    rate = require_controller(robot).rate
    binaries = {platform: path.read_bytes() for platform, path in fmu_binaries(fmi).items()}
    image = robot_image(robot)
    table = variables(robot, kind, sea=sea, pilot=b"missions.0." in image)
    lines = "".join(f"{variable.line}\n" for variable in table)
    space = "sea" if sea else "plane"
    digest = hashlib.sha256(b"\0".join([version().encode(), f"{fmi} {kind} {space}".encode(), lines.encode(), image]))
    token = str(uuid.uuid5(uuid.NAMESPACE_URL, digest.hexdigest()))
    name = "".join(letter if letter.isalnum() else "_" for letter in f"{robot.name}_{kind}")
    facts = {"name": f"{robot.name} {kind}", "identifier": name, "token": token, "tick": 1 / rate}
    files = {
        "modelDescription.xml": _description(facts, table, fmi).encode(),
        "resources/variables": f"hypertuna-fmu 1 {kind} {space} {token}\n{lines}".encode(),
        "resources/robot.image": image,
    }
    for platform, content in binaries.items():
        folder = PLATFORMS[platform] if fmi == 2 else platform
        files[f"binaries/{folder}/{name}{SUFFIXES[platform.partition('-')[2]]}"] = content
    return _zipped(files)


def fmu_binaries(fmi: int) -> dict[str, Path]:
    """Return the paths of the built binaries by platform; raise an error if there are none, or an outdated one."""
    try:
        folder = shipped(BINARIES)
    except StopIteration:
        folder = Path(BINARIES)
    paths = {platform: folder / platform / f"fmi{fmi}{SUFFIXES[platform.partition('-')[2]]}" for platform in PLATFORMS}
    built = {platform: path for platform, path in paths.items() if path.is_file()}
    if not built:
        fix = "run `make fmu` in a clone of hypertuna, or install a wheel that has them"
        raise InputError("must have a binary of one platform", key=f"{BINARIES} for FMI {fmi}", value="none", fix=fix)
    newest = max((file.stat().st_mtime for file in _sources()), default=0.0)
    if old := [platform for platform, path in built.items() if path.stat().st_mtime < newest]:
        fix = f"run `make fmu FMU_PLATFORMS='{' '.join(old)}'`, or remove the folders of platforms that you do not need"
        rule = "must not be older than its sources, core/include and hosts"
        raise InputError(rule, file=str(built[old[0]]), value="older", fix=fix)
    return built


def _sources() -> Iterator[Path]:
    """Yield the source files of the binaries in a clone; a wheel has none."""
    root = Path(__file__).parents[3]
    for folder in ("core/include", "hosts"):
        yield from (root / folder).rglob("*.[ch]*")


def _zipped(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive whose bytes depend only on the files' names and content."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.create_system, entry.compress_type = 3, zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content)
    return buffer.getvalue()


def _description(facts: Mapping[str, Any], table: list[Variable], fmi: int) -> str:
    """Return the text of modelDescription.xml."""
    token = "guid" if fmi == 2 else "instantiationToken"
    root = ElementTree.Element("fmiModelDescription", fmiVersion=f"{fmi}.0", modelName=facts["name"])
    root.set(token, facts["token"])
    root.set("version", version())
    root.set("generationTool", f"hypertuna {version()}")
    root.set("variableNamingConvention", "flat")
    flags = {"canHandleVariableCommunicationStepSize": True, "canBeInstantiatedOnlyOncePerProcess": False}
    if fmi == 2:
        flags |= dict.fromkeys(("canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate"), True)
        flags |= {"canSerializeFMUstate": True}
    else:
        flags |= {"canGetAndSetFMUState": True, "canSerializeFMUState": True, "fixedInternalStepSize": facts["tick"]}
    add(root, "CoSimulation", modelIdentifier=facts["identifier"], **flags)
    _units(root, {variable.unit for variable in table})
    add(add(root, "LogCategories"), "Category", name="logStatusError")
    add(root, "DefaultExperiment", startTime=0, stopTime=20, stepSize=facts["tick"])
    parent = add(root, "ModelVariables")
    for reference, variable in enumerate(table):
        _variable(parent, reference, variable, fmi)
    _structure(add(root, "ModelStructure"), table, fmi)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + document(root)


def _units(root: Element, used: Iterable[str]) -> None:
    """Add the definitions of the used units, with degrees as display unit of radians."""
    parent = add(root, "UnitDefinitions")
    for name, exponents in (UNITS[unit] for unit in UNITS if unit in used):
        unit = add(parent, "Unit", name=name)
        add(unit, "BaseUnit", **exponents)
        if name == "rad":
            add(unit, "DisplayUnit", name="deg", factor=DEGREE)


def _variable(parent: Element, reference: int, variable: Variable, fmi: int) -> None:
    """Add the XML element of a variable."""
    attributes: dict[str, Any] = {
        "name": variable.name,
        "valueReference": reference,
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality == "output" and fmi == 2:
        attributes["initial"] = "calculated"
    by_type: dict[str, Any] = dict(_type_attributes(variable))
    if fmi == 2:
        add(add(parent, "ScalarVariable", **attributes), variable.type, **by_type)
    else:
        add(parent, TYPES[variable.type], **attributes, **by_type)


def _type_attributes(variable: Variable) -> Iterator[tuple[str, Any]]:
    """Yield the attributes of a variable that depend on its type: unit, range and start."""
    if variable.unit in UNITS:
        yield "unit", UNITS[variable.unit][0]
    for key, value in (("min", variable.low), ("max", variable.high)):
        if value is not None:
            yield key, value
    if variable.start is not None:
        yield "start", bool(variable.start) if variable.type == "Boolean" else variable.start


def _structure(parent: Element, table: list[Variable], fmi: int) -> None:
    """Add the outputs; none depends on an input of the same tick, since inputs act from the next control tick on."""
    outputs = [k for k, variable in enumerate(table) if variable.causality == "output"]
    if fmi == 2:
        declared, initial = add(parent, "Outputs"), add(parent, "InitialUnknowns")
        for k in outputs:
            add(declared, "Unknown", index=k + 1, dependencies="")
            add(initial, "Unknown", index=k + 1)
        return
    for k in outputs:
        add(parent, "Output", valueReference=k, dependencies="")
    for k in outputs:
        add(parent, "InitialUnknown", valueReference=k)
