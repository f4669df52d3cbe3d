"""The description of a robot: `load` reads and checks robots/NAME.toml and returns a `Robot`."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Callable, Hashable, Iterator, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeVar

from pydantic import PrivateAttr, ValidationError, ValidationInfo, field_validator

from hypertuna.arguments import checked
from hypertuna.description.mistakes import translate
from hypertuna.description.schema.actuator import DriveUnit, Hinge, Material, hinges_in_order
from hypertuna.description.schema.base import Check, Name, Named, Part, Text, entry, number, same_length, unique
from hypertuna.description.schema.body import (
    Body,
    Fins,
    GaitBounds,
    JointGroup,
    Links,
    NamedGait,
    Spatial,
    fits,
)
from hypertuna.description.schema.control import Controller, Guidance, Sensor
from hypertuna.description.schema.firmware import Firmware
from hypertuna.description.schema.fit import Fitted
from hypertuna.description.schema.hydraulics import Battery, Oil, Pump, Servo
from hypertuna.description.schema.water import LAWS, Choice, Water
from hypertuna.description.validation import entry_of, field_at, fix_for, unit_of, values, written
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import read_toml
from hypertuna.io.files import shipped
from hypertuna.ranges import Range

T = TypeVar("T")

TOLERANCE = 1e-6  # relative tolerance of sums: of the links' lengths and of shares
Factor = Annotated[float, number(Range(min=1, max=100))]


class Entry(NamedTuple):
    """One value of a robot's description: key, value and unit as in the file, and the value's source."""

    key: str
    value: Any
    unit: str
    source: str | None  # entry of [sources], or the rule of the default
    default: bool = False  # whether the file does not give the value

    @property
    def estimate(self) -> bool:
        """Whether the value is an estimate."""
        return self.source is not None and self.source.startswith("estimate")

    @property
    def numeric(self) -> bool:
        """Whether the value is a number or a list of numbers."""
        values = self.value if isinstance(self.value, list) else [self.value]
        return all(type(x) in (int, float) for one in values for x in (one if isinstance(one, list) else [one]))


class Robot(Part, Plotted, Tabular):
    """A robot, described by one TOML file and read by `load`: SI units and radians, frozen; `using` returns another."""

    format: Literal[1] = entry("version of this format, 1", how="write 1")
    name: Name = entry("name of the robot", how="choose one: letters, digits, spaces and - _")
    description: Text = entry(
        "sentence that describes the robot (default: its name)",
        default_factory=lambda robot: robot["name"],
        how="write a sentence",
    )
    links: Links = entry("table of the links, nose to tail")
    body: Body = entry(
        "table of the whole robot's dimensions and mass", default_factory=lambda robot: Body().of(robot["links"])
    )
    joints: tuple[JointGroup, ...] = entry("list of joint groups, head to tail")
    model: Choice = entry("table of the model to use", default_factory=Choice)
    water: Water = entry("table of the water's density and coefficients")
    gaits: Annotated[dict[str, NamedGait], Named] = entry("named gaits", default_factory=dict)
    gait_bounds: GaitBounds | None = entry("table of the bounds of gaits", default=None)
    battery: Battery | None = entry("table of the battery", default=None)
    servos: tuple[Servo, ...] = entry("list of servos", default=())
    sensors: tuple[Sensor, ...] = entry("list of sensors", default=())
    materials: Annotated[dict[str, Material], Named] = entry("materials by name", default_factory=dict)
    drive_unit: DriveUnit | None = entry("table of the artificial muscle", default=None)
    pump: Pump | None = entry("table of one cylinder of the pump", default=None)
    oil: Oil | None = entry("table of the hydraulic oil", default=None)
    controller: Controller | None = entry("table of the controller on board", default=None)
    guidance: Guidance | None = entry("table of the pilot on board", default=None)
    firmware: Firmware | None = entry("table of the microcontroller on board", default=None)
    spatial: Spatial | None = entry("table of the links beyond the plane", default=None)
    fins: Fins | None = entry("table of the pectoral fins", default=None)
    hinge: Hinge | None = entry("table of a hinge in the tail", default=None)
    hinge_list: tuple[Hinge, ...] | None = entry(
        "list of hinges in the tail, nose to tail, instead of [hinge]", key="hinges", default=None
    )
    fit: Fitted | None = entry("table that `hypertuna identify` writes", default=None)
    uncertainty: dict[str, Factor] | None = entry(
        "factor within which the true value of an estimate lies in 90 % of cases, by key or the start of a key",
        default=None,
        how="write 2 if the true value lies from a half to twice the estimate",
    )
    sources: dict[str, Text] = entry(
        "source of each value, by key or the start of a key",
        default_factory=dict,
        how='write where each value is from; begin estimates with "estimate"',
    )

    _file: str = PrivateAttr(default="")

    @field_validator("body")
    @classmethod
    def _sum_links(cls, body: Body, info: ValidationInfo) -> Body:
        """Return the body with length and mass filled in from the links, if these are valid."""
        return body.of(info.data["links"]) if "links" in info.data else body

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        """The hinges, nose to tail; among the tail's coordinates, they come after the joint groups."""
        return self.hinge_list or () if self.hinge is None else (self.hinge,)

    @property
    def hinge_keys(self) -> tuple[str, ...]:
        """Keys of the tables of the hinges: ``hinge``, or ``hinges[0]`` and so on."""
        return ("hinge",) if self.hinge else tuple(f"hinges[{d}]" for d in range(len(self.hinges)))

    @property
    def file(self) -> str:
        """File of the robot; empty without one."""
        return self._file

    @cached_property
    def hash(self) -> str:
        """SHA-256 of all values that affect results: all but description, sources and the table of the firmware."""
        texts = {"description", "sources", "firmware"}
        content = self.model_dump(mode="json", by_alias=True, exclude_none=True, exclude=texts)
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def __copy__(self) -> Self:
        """Return a copy of the fields, without cached results, which would not fit a changed copy."""
        copy = super().__copy__()
        for name in copy.__dict__.keys() - type(self).model_fields.keys():
            del copy.__dict__[name]
        return copy

    def document(self) -> dict[str, Any]:
        """Return the content of the robot's file.

        Returns
        -------
        dict
            Input of `parse`: keys with units, angles in degrees, no defaults.
        """
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)

    def using(self, *, water: str | None = None, joints: str | None = None, areas: str | None = None) -> Robot:
        """Return the robot with another water law, joint model or areas.

        Parameters
        ----------
        water, joints, areas : str, optional
            Values of the table ``[model]``; None keeps the present one.

        Returns
        -------
        Robot
            The checked robot; its hash differs if the choice does.

        Raises
        ------
        InputError
            If the choice does not exist, or the robot lacks its coefficients.
        """
        choice = {k: v for k, v in {"water": water, "joints": joints, "areas": areas}.items() if v is not None}
        if not choice:
            return self
        document = self.document()
        return parse(document | {"model": document["model"] | choice}, file=self.file)

    def source(self, key: str) -> str | None:
        """Return the source of a value: the longest entry of ``[sources]`` with which its key starts.

        Parameters
        ----------
        key : str
            Key as in the file, with or without indices: ``links.mass_kg[2]``.

        Returns
        -------
        str or None
            The source; None without one.
        """
        return entry_of(self.sources, key)

    def entries(self) -> tuple[Entry, ...]:
        """Return all values of the robot with their units and sources, defaults included.

        Returns
        -------
        tuple of Entry
            Key, value and unit as in the file, and source; for values that the file does not give, the default's rule.
        """
        texts = {"format", "name", "description", "uncertainty", "sources"}
        content = self.model_dump(mode="json", by_alias=True, exclude_none=True, exclude=texts)
        given_keys = {written(place) for place, _ in values(self.document())}
        entries = []
        for place, value in values(content):
            key, (_, field) = written(place), field_at(type(self), place)
            default, source = key not in given_keys, self.source(key)
            if default and re.sub(r"\[\d+\]", "", key) not in self.sources:
                rule = re.search(r"\((default: .*)\)$", (field and field.description) or "")
                source = rule[1] if rule else "default"
            entries.append(Entry(key, value, unit_of(field), source, default))
        return tuple(entries)

    def unsourced(self) -> tuple[str, ...]:
        """Return the keys of the file's numbers that have no source.

        Returns
        -------
        tuple of str
            Their keys.
        """
        return tuple(e.key for e in self.entries() if not e.default and e.numeric and e.source is None)

    def _checks(self) -> Iterator[Check]:
        """Check the tables of the file against each other."""
        links, groups, length, mass = self.links, len(self.joints), sum(self.links.length), sum(self.links.mass)
        text, fix = f"must add up to body.length_m = {self.body.length:g}", "correct the links or the body length"
        adds_up = math.isclose(length, self.body.length, rel_tol=TOLERANCE)
        yield Check(adds_up, "links.length_m", text, fix, f"{length:g} in all")
        text = f"must add up to at most body.mass_kg = {self.body.mass:g}"
        fix = f"correct the links{' (in g?)' * (mass > 100 * self.body.mass)} or the mass of the whole robot"
        yield Check(mass <= self.body.mass * (1 + TOLERANCE), "links.mass_kg", text, fix, f"{mass:g} in all")
        yield from self._joint_checks()
        law = self.model.water
        fix = f"add the table [water.{law}] or choose another law in [model]"
        present = getattr(self.water, law) is not None
        yield Check(present, "model.water", "must be a law with coefficients", fix, repr(law))
        fix = "give it in Hz, or choose joints = 'ideal' in [model]"
        for g, group in enumerate(self.joints):
            present = self.model.joints != "bandwidth" or group.bandwidth is not None
            yield Check(present, f"joints[{g}].bandwidth_hz", "is missing for model.joints = 'bandwidth'", fix)
        for name in LAWS:
            if (part := getattr(self.water, name)) is not None:
                yield from same_length(part, f"water.{name}", len(links.name), "link")
        if self.spatial is not None:
            yield from same_length(self.spatial, "spatial", len(links.name), "link")
            yield from self.spatial.centers(links.length)
        if self.fins is not None:
            yield self.fins.on_head(links.length[0])
        both = self.hinge is not None and self.hinge_list is not None
        yield Check(not both, "hinge_list", "must not stand beside [hinge]", "make it the first of [[hinges]]", "given")
        yield from hinges_in_order(dict(zip(self.hinge_keys, self.hinges, strict=True)), len(links.name) - 1)
        for name, gait in self.gaits.items():
            yield from same_length(gait, f"gaits.{name}", groups, "joint group")
        if self.gait_bounds is not None:
            yield from same_length(self.gait_bounds, "gait_bounds", groups, "joint group", but=("frequency",))
        if self.guidance is not None:
            yield from self.guidance.check_robot(self.gaits, groups)
        if self.firmware is not None:
            quantities = {sensor.quantity for sensor in self.sensors if sensor.quantity is not None}
            yield from self.firmware.pin_checks([group.drive for group in self.joints], quantities)
        if self.drive_unit is not None:
            yield from self.drive_unit.check_materials(self.materials)
        yield from fits(self.body.length, self.joints, self.drive_unit, self.pump)
        yield from self._source_checks()

    def _joint_checks(self) -> Iterator[Check]:
        """Check that each joint is in one group at most, and that the shares of a group add up to one."""
        yield from unique(tuple(group.name for group in self.joints), "joints[{}].name")
        last = len(self.links.name) - 1
        owner: dict[int, int] = {}
        for g, group in enumerate(self.joints):
            yield from same_length(group, f"joints[{g}]", len(group.links), "link of the group")
            for k, link in enumerate(group.links):
                key = f"joints[{g}].links[{k}]"
                fix = "joint i sits at the front end of link i, and link 0 is the head"
                yield Check(1 <= link <= last, key, f"must be a link from 1 to {last}", fix, shown(link))
                other, text = owner.get(link), "must be in one joint group only"
                yield Check(other is None, key, text, "remove it from one", f"{link}, which joints[{other}] has too")
                owner[link] = g
            yield from group.one_drive(f"joints[{g}]")
            total, fix = sum(group.share), "leave share out for equal shares"
            adds_up = math.isclose(total, 1, rel_tol=TOLERANCE)
            yield Check(adds_up, f"joints[{g}].share", "must add up to 1", fix, f"{total:g} in all")
            if group.line is not None and self.controller is not None:
                yield self.controller.fill(group.line.fill_pressure, f"joints[{g}].line.fill_pressure_pa")

    def _source_checks(self) -> Iterator[Check]:
        """Check that every entry of [sources] and [uncertainty] is a key with a value, or the start of such a key."""
        about: dict[str, Mapping[str, Any]] = {"uncertainty": self.uncertainty or {}, "sources": self.sources}
        if not any(about.values()):
            return
        content = self.model_dump(mode="json", by_alias=True, exclude_none=True, exclude={*about})
        places = dict.fromkeys(tuple(part for part in place if isinstance(part, str)) for place, _ in values(content))
        starts = dict.fromkeys(place[:n] for place in places for n in range(1, len(place) + 1))
        existing = dict.fromkeys(map(written, starts))
        for table, key in ((table, key) for table, keys in about.items() for key in keys):
            fix = "" if key in existing else did_you_mean(key, existing)
            yield Check(key in existing, written((table, key)), "must be a key with a value", fix)


class _Cache(dict[Hashable, Any]):
    """Objects that other modules built from a robot, by key; a copied or pickled cache is empty."""

    def __reduce__(self) -> tuple[type[_Cache], tuple[()]]:
        return _Cache, ()


def cached(robot: Robot, key: Hashable, make: Callable[[], T]) -> T:
    """Return the object that `make` builds from a robot, once per robot and key; it is kept with the robot."""
    cache = robot.__dict__.setdefault("_cache", _Cache())
    if key not in cache:
        cache[key] = make()
    result: T = cache[key]
    return result


def robots() -> tuple[str, ...]:
    """Return the names of the robots that come with hypertuna.

    Returns
    -------
    tuple of str
        Names for `load`.
    """
    return tuple(sorted(path.stem for path in shipped("robots").glob("*.toml")))


@checked
def load(robot: str | Path) -> Robot:
    """Read and check the description of a robot, given its name or its file.

    Parameters
    ----------
    robot : str or Path
        The name of a robot that comes with hypertuna (see `robots`), or the path of a TOML file.

    Returns
    -------
    Robot
        The robot, in SI units and radians.

    Raises
    ------
    InputError
        If the file is missing or invalid: one sentence with file, key, rule, value and fix.
    """
    by_name = not str(robot).lower().endswith(".toml") and not set("/\\") & set(str(robot))
    file = f"robots/{robot}.toml" if by_name else str(robot)
    path = shipped("robots") / f"{robot}.toml" if by_name else Path(robot)
    if by_name and os.path.isdir(robot):
        raise InputError("is a folder", file=str(robot), fix="give the path of a TOML file")
    if by_name and not path.exists() and os.path.exists(robot):
        raise InputError("is not a robot", file=str(robot), fix="give a robot's name or the path of its TOML file")
    if not os.path.exists(path):
        fix = did_you_mean(str(robot), robots()) if by_name else "give a robot's name or the path of its TOML file"
        raise InputError("does not exist", file=file, fix=fix)
    return parse(read_toml(path, file=file), file=file)


def robot_of(robot: Robot | str | Path) -> Robot:
    """Return a robot, which is loaded if a name or a file is given."""
    return robot if isinstance(robot, Robot) else load(robot)


def parse(document: Mapping[str, Any], *, file: str = "") -> Robot:
    """Return the robot that a document of `tomllib` describes; `file` is named in errors and kept as ``Robot.file``."""
    try:
        robot = Robot.model_validate(document)
    except ValidationError as error:
        from hypertuna.description.new import example  # only errors need it

        raise translate(error, document, Robot, file or None, partial(example, file=file)) from None
    robot._file = file
    return robot


def joint_key(robot: Robot, name: str) -> str:
    """Return the key, such as ``joints[0]``, of the joint group with a name."""
    return f"joints[{[group.name for group in robot.joints].index(name)}]"


def require(value: T | None, key: str, robot: Robot | None = None, fix: str | None = None) -> T:
    """Return an optional value of a robot; InputError if it is None: ``require(robot.pump, "pump", robot)``.

    The default fix is from the schema: the table to add, or the value with its unit.
    """
    if value is None:
        raise InputError("is missing", file=(robot and robot.file) or None, key=key, fix=fix or fix_for(Robot, key))
    return value
