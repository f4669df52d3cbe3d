"""Names of free coefficients: find the parameters of the robot that a name selects, and which of them are tied."""

import re
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

from hypertuna.description.provenance import factor_of, is_estimate
from hypertuna.description.robot import Robot
from hypertuna.description.schema.water import LAWS
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.identification.columns import file_key, is_spring, known_columns
from hypertuna.io.files import shipped
from hypertuna.ranges import check_name

NUISANCES = {
    "time_offset": "s",
    "cost_factor": "1",
}  # by name of a coefficient of the trials, not of the robot: its unit
# A name such as water.drag[0,1-6]=common.
NAME = re.compile(r"(?P<column>[\w.]+)(?:\[(?P<index>.*?)\])?(?P<common>=common)?")
HINGE = re.compile(r"^hinges\[(.*?)\]\.(\w+)")  # one of several hinges, as files have it: hinges[0].stiffness
ALONG = ("friction", "drag_tangential")  # columns of drag along the body
DEFAULT_COLUMNS = (
    *ALONG,
    "drag",
    "drag_normal",
    "added_mass",
    "added_mass_normal",
    "blunt_area",
)  # columns that are free by default
SIGNED = ("phase_offset", "rest", "moment_phase")  # values of columns that may be negative
ANGLES = (*SIGNED, "stop")  # values of columns that are angles
# unit at the end of a key in the robot's file
UNIT = re.compile("_(kg_m2|kg_m3|m2|m3|m|kg|hz|deg|pa|n_m|n_m_per_rad|n_m_s_per_rad|n_m_per_rad3|n_m_s_per_rad2)$")
Z_90 = 1.645  # standard deviations to either side that contain 90 % of normal errors
COMMON = "=common"  # end of a name that means a common factor on several values instead of a common value


def split_names(text: str) -> list[str]:
    """Split names at commas outside brackets.

    >>> split_names("water.drag[0,1-6,7], joints.bandwidth")
    ['water.drag[0,1-6,7]', 'joints.bandwidth']
    """
    return [name.strip() for name in re.split(r",(?![^\[]*\])", text) if name.strip()]


def value_of(name: str) -> str:
    """Return what a name's values are, without table, index and unit: "bandwidth" of ``joints.bandwidth_hz[0]``."""
    return UNIT.sub("", re.sub(r"\[.*?\]", "", name).removesuffix(COMMON).rpartition(".")[2])


def two_lines(name: str) -> str:
    """Return a name with a line break after its table, unchanged without a table."""
    end = name.partition("[")[0].rfind(".") + 1
    return f"{name[:end]}\n{name[end:]}" if end else name


@cache
def default_bounds() -> dict[str, Any]:
    """Read data/published/bounds.toml: bounds and starts by column [SI], and bounds of links as factors."""
    return tomllib.loads((shipped("data/published") / "bounds.toml").read_text(encoding="utf-8"))


def bounds_table(column: str) -> dict[str, Any]:
    """Return bounds and start of a column in data/published/bounds.toml [SI]; {} if it has none."""
    table: dict[str, Any] = default_bounds()["coefficient"].get(column.replace("hinges.", "hinge."), {})
    return table


def factor_table(column: str) -> dict[str, Any]:
    """Return the bounds of a column without its own in data/published/bounds.toml, over the described value."""
    factors: dict[str, dict[str, Any]] = default_bounds()["factor"]
    return factors.get(value_of(column)) or factors["springs" if is_spring(column) else "links"]


class FreeValue(NamedTuple):
    """One free value, for a whole column or for some tied parameters of it."""

    column: str  # as `parameter_names` writes it
    at: str  # indices such as 0+2-4, the name of a recording, or ""
    common: bool = False  # whether the value is a factor on the present values

    @property
    def name(self) -> str:
        """Name with indices in brackets."""
        return (f"{self.column}[{self.at}]" if self.at else self.column) + COMMON * self.common

    @property
    def members(self) -> tuple[Any, ...]:
        """Indices that share the value, (0,) for a column of one value; for a time offset, its recording's name."""
        if self.column in NUISANCES or not self.at:
            return (self.at or 0,)
        ends = [[int(end) for end in part.split("-")] for part in self.at.split("+")]
        return tuple(i for end in ends for i in range(end[0], end[-1] + 1))


def default_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the default coefficients: a factor on each of the water law's drags and added masses.

    A column whose present values are all 0 is left at 0, except drag along the body, which all swimmers have.
    """
    law = robot.model.water
    names = []
    for column in DEFAULT_COLUMNS:
        full_name = f"water.{law}.{column}"
        value = getattr(getattr(robot.water, law), column, None)
        if value is None:
            continue
        present = value if isinstance(value, tuple) else (value,)
        if any(present):
            names.append(full_name + COMMON * (len(present) > 1))
        elif column in ALONG:
            names.append(full_name)
    return tuple(names)


def default_priors(robot: Robot) -> dict[str, float]:
    """Return by name the factors by which the robot's values of the default coefficients may be off."""
    factors = {name: prior_factor(robot, name.removesuffix(COMMON)) for name in default_names(robot)}
    return {name: factor for name, factor in factors.items() if factor is not None}


def prior_factor(robot: Robot, column: str) -> float | None:
    """Return the factor by which the robot's values of a column may be off, one standard deviation of the logarithm.

    The factor is the larger of the handbooks' and that of the file's [uncertainty], since a prior as narrow as the rule
    of an estimate would hold a fit too close to the estimate. None if there is neither, or for a spring whose source
    is no estimate.
    """
    if is_spring(column) and not is_estimate(robot, file_key(column)):
        return None
    factors = default_bounds()["prior"].get(column.rpartition(".")[2], {})
    has_blunt_area = any(getattr(getattr(robot.water, robot.model.water), "blunt_area", ()))
    handbook = factors.get("beside_blunt_area" if has_blunt_area and "beside_blunt_area" in factors else "factor", 1.0)
    factor = float(max(handbook, factor_of(robot, file_key(column)) ** (1 / Z_90)))
    return factor if factor > 1 else None


def common_place(column: str, members: Sequence[int], count: int, common: bool = True) -> str:
    """Return the name of one factor on some of `count` values of a column, or of one value for all of them."""
    return FreeValue(column, _canonical(members) if count else "", common).name


def free_of(robot: Robot, names: Sequence[str]) -> tuple[str, ...]:
    """Return those of the names that apply to the robot's water law; names: a list for several laws."""
    other_laws = LAWS.keys() - {robot.model.water}
    known_columns = Names(robot).known

    def applies(name: str) -> bool:
        column = name.removesuffix(COMMON).partition("[")[0]
        if column.split(".")[0] != "water" or column in known_columns:
            return True
        law, _, key = column.removeprefix("water.").rpartition(".")
        return law not in other_laws and (bool(law) or f"water.{robot.model.water}.{key}" in known_columns)

    return tuple(name for name in names if applies(name))


@dataclass(frozen=True)
class Names:
    """The names of coefficients that can be free, for a robot and the recordings of its trials."""

    robot: Robot
    recordings: tuple[str, ...] = ()

    @cached_property
    def known(self) -> dict[str, int]:
        """By column: its number of values, 0 for a single value without an index."""
        return known_columns(self.robot) | dict.fromkeys(NUISANCES, 0)

    def resolve(self, name: str, key: str) -> list[FreeValue]:
        """Return the places that a name selects; key: names the argument in errors."""
        where = f"{key} {name}"
        name = HINGE.sub(r"hinges.\2[\1]", name)
        match = NAME.fullmatch(name)
        column, index = (match["column"], match["index"]) if match else (name, None)
        column = UNIT.sub("", column) if column not in self.known else column
        full_column = f"water.{self.robot.model.water}.{column.removeprefix('water.')}"
        if column not in self.known and column.startswith("water.") and full_column in self.known:
            column = full_column
        if column not in self.known:
            raise self._unknown(name, where)
        if column.startswith("joints.bandwidth") and self.robot.model.joints == "ideal":
            fix = "choose joints = 'bandwidth' in [model], or joints='bandwidth' to Robot.using"
            raise InputError("is not used by model.joints = 'ideal'", file=self.robot.file, key=where, fix=fix)
        if column == "time_offset":
            selected = self.recordings if index is None else (index,)
            for recording in selected:
                check_name(recording, self.recordings, where, "recording of the trials")
            if not selected:
                rule = "needs recordings of joint angles, and the trials have none"
                raise InputError(rule, key=where, fix="leave it out")
            return [FreeValue(column, recording) for recording in selected]
        count = self.known[column]
        common = bool(match and match["common"])
        if common and column in NUISANCES:
            raise InputError(
                "is not a value of the robot and cannot have a common factor", key=where, fix=f"write {column}"
            )
        if index is None:
            return [FreeValue(column, _canonical(range(count)) if count else "", common)]
        if not count:
            raise InputError("has one value only", key=where, fix=f"write {column} without brackets")
        if common and index.strip() == "*":
            return [FreeValue(column, _canonical(range(count)), True)]
        parts = [str(i) for i in range(count)] if index.strip() == "*" else index.split(",")
        return [
            FreeValue(column, _canonical(self._indices(column, part.strip(), count, where)), common) for part in parts
        ]

    def covered(self, name: str, places: Sequence[FreeValue], key: str) -> list[FreeValue]:
        """Return those of `places` that a name covers; raise an error if there are none."""
        wide = self.resolve(name, key)
        members = {member for place in wide for member in place.members}
        matching = [place for place in places if place.column == wide[0].column and members.issuperset(place.members)]
        if not matching:
            fix = did_you_mean(name, [place.name for place in places])
            raise InputError("must be a free coefficient", key=f"{key} {name}", fix=fix)
        return matching

    def _unknown(self, name: str, where: str) -> InputError:
        """Return the error for a name that cannot be free."""
        column, own_law = name.partition("[")[0], self.robot.model.water
        law = column.removeprefix("water.").partition(".")[0]
        if column.startswith("water.") and law in LAWS.keys() - {own_law}:
            return InputError(
                f"is not used by model.water = {own_law!r}", key=where, fix=f"choose water = '{law}' in [model]"
            )
        if is_spring(column) and not self.robot.hinges:
            fix = "leave it out, or add the table [hinge]"
            return InputError(
                "belongs to a hinge, which the robot lacks", file=self.robot.file or None, key=where, fix=fix
            )
        if column.startswith("gait."):
            fix = "free coefficients of water, joints or links"
            return InputError("belongs to the gait, which the trials give", key=where, fix=fix)
        law_columns = [known for known in self.known if known.startswith("water.") and known.count(".") == 2]
        fix = did_you_mean(column, [*self.known, *(f"water.{known.rpartition('.')[2]}" for known in law_columns)])
        _, bracket, index = name.partition("[")
        fix = re.sub(r"(did you mean [\w.]+)\?$", rf"\1{bracket}{index}?", fix)
        return InputError("is not a coefficient that can be free", key=where, fix=fix)

    def _indices(self, column: str, text: str, count: int, where: str) -> list[int]:
        """Parse an index, a range, or several tied by +; names of links and joint groups stand for their indices."""
        groups = [group.name for group in self.robot.joints]
        names = groups if column.startswith("joints.") else [] if is_spring(column) else list(self.robot.links.name)
        indices: set[int] = set()
        for part in (part.strip() for part in text.split("+")):
            match = re.fullmatch(r"(\d+)(?:-(\d+))?", part)
            if part in names:
                indices.add(names.index(part))
            elif match and int(match[1]) <= int(match[2] or match[1]) < count:
                indices |= set(range(int(match[1]), int(match[2] or match[1]) + 1))
            else:
                ranges = f"indices from 0 to {count - 1}, ranges such as 1-{count - 1}"
                rule = f"must have {ranges}" + f", or names ({', '.join(names)})" * bool(names)
                raise InputError(rule, key=where, value=shown(part), fix="write an index within the range")
        return sorted(indices)


def _canonical(indices: Iterable[int]) -> str:
    """Format indices as ranges tied by +, such as 0+2-4."""
    parts: list[list[int]] = []
    for i in indices:
        if parts and parts[-1][-1] == i - 1:
            parts[-1] = [parts[-1][0], i]
        else:
            parts.append([i])
    return "+".join("-".join(str(end) for end in part) for part in parts)
