"""Published swimmers: files in which every number has a source (see data/swimmers/README.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from hypertuna.description.mistakes import translate
from hypertuna.description.new import LINKS
from hypertuna.description.schema.base import (
    Amplitude,
    Check,
    Degrees,
    Name,
    NotNegative,
    Part,
    Positive,
    PositiveFraction,
    Text,
    entry,
    unique,
)
from hypertuna.errors import InputError, did_you_mean
from hypertuna.io.door import read_toml
from hypertuna.io.files import shipped

FOLDER = "data/swimmers"
MOST = 100  # largest number of a swimmer's runs
LONGEST = 60  # longest name of a run, in characters


class Body(Part, table="body"):
    """The robot as a whole."""

    length: Positive = entry("length from nose to tail tip", "m")
    mass: Positive | None = entry("mass", "kg", default=None)
    height: Positive | None = entry("largest height of the body without fins", "m", default=None)
    width: Positive | None = entry("largest width of the body", "m", default=None)


class Links(Part, table="links"):
    """The rigid links."""

    length: tuple[Positive, ...] = entry(
        "length of each link, nose to tail", "m", min_length=LINKS.min, max_length=LINKS.max
    )


class Fin(Part, table="fin"):
    """The caudal fin."""

    span: Positive | None = entry("span, from tip to tip", "m", default=None)
    area: Positive | None = entry("area of one side", "m^2", default=None)
    chord: Positive | None = entry("mean chord", "m", default=None)


class Run(Part, table="runs"):
    """A steady swim, or the thrust of a fish held fixed."""

    name: Text = entry("name of the run", max_length=LONGEST)
    frequency: Positive = entry("beat frequency", "Hz")
    speed: NotNegative = entry("mean speed; 0 for a fish held fixed", "m/s")
    speed_error: PositiveFraction | None = entry("relative error of the speed", default=None)
    excursion: Positive | None = entry("excursion of the tail tip, peak to peak", "m", default=None)
    amplitude: tuple[Amplitude, ...] | None = entry("amplitude of each joint group", "deg", default=None)
    phase: tuple[Degrees, ...] | None = entry("lag of each joint group", "deg", default=None)
    power: Positive | None = entry("mean power", "W", key="power_w", default=None)
    power_kind: Literal["electrical", "mechanical"] | None = entry("what power it is", key="power", default=None)
    thrust: Positive | None = entry("mean thrust of a fish held fixed", "N", default=None)

    def _checks(self) -> Iterator[Check]:
        """Check that a run has a speed or, held fixed, a thrust."""
        fix = "give thrust_n of a fish held fixed, with speed_m_s = 0, else a speed above 0 alone"
        yield Check((self.thrust is None) == (self.speed > 0), "speed", "must be above 0, or be 0 beside thrust_n", fix)
        paired = (self.power is None) == (self.power_kind is None)
        yield Check(paired, "power_kind", "must stand beside power_w", "give power_w and its kind, or neither")

    @property
    def published(self) -> float:
        """The published number: speed [m/s], or of a fish held fixed the thrust [N]."""
        return self.speed if self.thrust is None else self.thrust


class Swimmer(Part):
    """A published swimmer: what a builder would know of it, and what it did."""

    name: Name = entry("name of the swimmer")
    reference: Text = entry("work that describes it")
    nose: Literal["streamlined", "robot", "blunt"] = entry("shape of the nose, as for `hypertuna robot new`")
    links: int | Links = entry("number of links, or table of their lengths")
    joints: tuple[Name, ...] = entry("names of the joint groups (default: one for each link)", default=())
    body: Body = entry("table of the body")
    fin: Fin = entry("table of the caudal fin", default_factory=Fin)
    runs: tuple[Run, ...] = entry("list of runs", min_length=1, max_length=MOST)
    sources: dict[str, Text] = entry("source of each value, by key or the start of a key")

    def _checks(self) -> Iterator[Check]:
        """Check the number of links and angles, the lengths, names, and that every number has a source."""
        yield Check(self.link_count in LINKS, "links", LINKS.rule, "a head, and one link behind each joint")
        total = math.fsum(self.lengths) if self.lengths else self.body.length
        adds_up, rule = math.isclose(total, self.body.length, rel_tol=0.01), "must add up to body.length_m within 1 %"
        yield Check(adds_up, "links.length_m", rule, "correct one of the two", f"{total:g} m in all")
        groups = len(self.joints) or self.link_count - 1
        yield from unique(tuple(run.name for run in self.runs), "runs[{}].name")
        for k, run in enumerate(self.runs):
            for name, angles in (("amplitude_deg", run.amplitude), ("phase_deg", run.phase)):
                rule, value = f"must be {groups} long, one value per joint group", f"{len(angles or ())} long"
                fits = angles is None or len(angles) == groups
                yield Check(fits, f"runs[{k}].{name}", rule, f"give {groups} values", value)
        yield from self._source_checks()

    def _source_checks(self) -> Iterator[Check]:
        """Check that every number and the nose have a source, and every source a key."""
        content = self.model_dump(
            mode="json", by_alias=True, exclude_none=True, exclude={"sources", "name", "reference"}
        )
        keys = dict.fromkeys(_keys(content))
        starts = dict.fromkeys(start for key in keys for start in _starts(key))
        for key in (key for key in keys if key.rpartition(".")[2] not in ("name", "joints", "power")):
            fix = f'write "{key}" = "Table 1", for example, in [sources]'
            yield Check(any(start in self.sources for start in _starts(key)), key, "must have a source", fix)
        for key in self.sources:
            yield Check(key in starts, f'sources."{key}"', "must be a key with a value", did_you_mean(key, starts))

    @property
    def lengths(self) -> tuple[float, ...]:
        """Lengths of the links [m]; empty where they are not published."""
        return self.links.length if isinstance(self.links, Links) else ()

    @property
    def link_count(self) -> int:
        """Number of links."""
        return len(self.links.length) if isinstance(self.links, Links) else self.links

    def assumes_excursion(self, run: Run) -> bool:
        """Whether the excursion of a run is an estimate, not published: neither it nor the angles."""
        keys = {"runs.excursion_m": run.excursion, "runs.amplitude_deg": run.amplitude}
        starts = [
            [s for s in _starts(key) if s in self.sources][-1] for key, value in keys.items() if value is not None
        ]
        return all(self.sources[start].startswith("estimate") for start in starts)


def _keys(value: Any, place: str = "") -> Iterator[str]:
    """Yield the dotted keys of all values of a document, without the indices of lists."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _keys(part, f"{place}.{name}".lstrip("."))
    elif isinstance(value, list) and value and isinstance(value[0], Mapping):
        for part in value:
            yield from _keys(part, place)
    elif value not in ([], {}):
        yield place


def _starts(key: str) -> list[str]:
    """Return the starts of a key: a, a.b, a.b.c."""
    parts = key.split(".")
    return [".".join(parts[:n]) for n in range(1, len(parts) + 1)]


def swimmers() -> tuple[str, ...]:
    """List the published swimmers that come with hypertuna."""
    return tuple(sorted(path.stem for path in shipped(FOLDER).glob("*.toml")))


def read_swimmer(swimmer: str | Path) -> Swimmer:
    """Read a published swimmer: the name of one that comes with hypertuna, or the path of a TOML file."""
    by_name = not str(swimmer).lower().endswith(".toml")
    if by_name and swimmer not in swimmers():
        fix = did_you_mean(str(swimmer), swimmers())
        raise InputError("must be a known swimmer or the path of a .toml file", key=str(swimmer), fix=fix)
    path = shipped(FOLDER) / f"{swimmer}.toml" if by_name else Path(swimmer)
    document = read_toml(path)
    try:
        return Swimmer.model_validate(document)
    except ValidationError as error:
        raise translate(error, document, Swimmer, str(path)) from None
