"""The scoreboard: published numbers of swimmers beside predicted ones, and what they say about the predictions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.display import Plotted, Tabular
from hypertuna.io.files import dataset, version
from hypertuna.io.quantity import Quantity, key_of
from hypertuna.paper.ledger import Entry, Finding, judge
from hypertuna.scoreboard.fits import Other
from hypertuna.scoreboard.laws import Shoal

if TYPE_CHECKING:
    import xarray as xr

UNITS = {"speed": "m/s", "thrust": "N", "electrical power": "W", "mechanical power": "W"}  # of quantities
SIZES = {"length": "m", "frequency": "Hz", "excursion": "m"}  # other fields of a score -> unit
NEAR, FAR = 1.3, 2.0  # factors of predicted over published within which swimmers are counted
MODEL = "robot new"  # name of the model that is scored
# Limits of a true excursion over the assumed one: swimmers' excursions are 0.1 to 0.3 of their length (Saadat et al.
# 2017), and 0.2 is assumed if none is published. Speed is proportional to the excursion.
EXCURSIONS = 0.5, 1.5


@dataclass(frozen=True)
class Score:
    """A published number of a run, and what a first robot predicts [SI]."""

    swimmer: str
    run: str
    quantity: str  # of `UNITS`
    published: float
    published_error: float | None  # relative, as published
    predicted: float  # by `hypertuna robot new` and its defaults; NaN without a prediction
    low: float = math.nan  # band of speeds that the robot's estimates allow; NaN without one
    high: float = math.nan
    own: float = math.nan  # predicted with the swimmer's own sections; NaN where none are published
    length: float = math.nan  # m, of the swimmer
    frequency: float = math.nan  # Hz
    excursion: float = math.nan  # m, peak to peak, as predicted
    assumed: bool = False  # whether the excursion is an estimate
    reference: str = ""
    note: str = ""  # why there is no prediction

    @property
    def ratio(self) -> float:
        """Predicted over published."""
        return self.predicted / self.published

    @property
    def band(self) -> tuple[float, float] | None:
        """The 90 % band, if it is known: of the estimates, and of the excursion where it is assumed."""
        if not (math.isfinite(self.low + self.high) and self.low > 0):
            return None
        if not self.assumed:
            return self.low, self.high
        ends = zip((self.low, self.high), EXCURSIONS, strict=True)
        widths = [math.hypot(math.log(end / self.predicted), math.log(factor)) for end, factor in ends]
        return self.predicted * math.exp(-widths[0]), self.predicted * math.exp(widths[1])

    @property
    def inside(self) -> bool | None:
        """Whether the published number is inside the 90 % band; None without a band."""
        return None if self.band is None else self.within(*self.band)

    def within(self, low: float, high: float) -> bool:
        """Whether the published number, give or take its error, is between two others."""
        error = self.published * (self.published_error or 0.0)
        return low <= self.published + error and self.published - error <= high

    @property
    def entry(self) -> Entry:
        """The number as an entry of a ledger."""
        key, unit = f"{self.quantity}/{self.swimmer}/{self.run}", UNITS[self.quantity]
        fact = {"value": self.published, "unit": unit, "kind": "measured", "source": self.reference}
        finding = Finding(key, MODEL, "prediction", self.predicted, self.note, self.band)
        return judge({"values": {key: fact}}, finding)

    @property
    def verdict(self) -> str | None:
        """The verdict by the band, as a ledger has it; None without a band."""
        return None if self.band is None else self.entry.verdict


@dataclass(frozen=True)
class Statistics:
    """How well speeds are predicted; every swimmer counts once, by the geometric mean of its runs."""

    swimmers: int  # number with a prediction
    missing: int  # number without one
    rms_log: float  # root mean square of the natural logarithm of predicted over published
    mean_ratio: float  # geometric
    within_near: int  # swimmers within a factor of 1.3
    within_far: int  # swimmers within a factor of 2
    factor: float  # nine of ten swimmers are within this factor


def statistics(scores: Sequence[Score], *, own: bool = False) -> Statistics:
    """Return statistics of the predicted speeds: by the defaults, or with `own` sections where these are published."""
    ratios = ratios_of(scores, own=own)
    logs = swimmer_logs(ratios)
    values = np.array([*logs.values()])
    magnitudes = np.abs(values)
    return Statistics(
        swimmers=len(logs),
        missing=len(ratios) - len(logs),
        rms_log=_rms(values),
        mean_ratio=math.exp(values.mean()) if len(logs) else math.nan,
        within_near=int((magnitudes <= math.log(NEAR)).sum()),
        within_far=int((magnitudes <= math.log(FAR)).sum()),
        factor=math.exp(np.quantile(magnitudes, 0.9, method="inverted_cdf")) if len(logs) else math.nan,
    )


def coverage(scores: Sequence[Score], *, estimates_alone: bool = False) -> tuple[float, float]:
    """Return the mean over swimmers of the share of speeds inside the band, and the median of upper over lower end.

    The band is that of the estimates and of assumed excursions, or of the `estimates_alone`; NaN without bands.
    """
    inside: dict[str, list[bool]] = {}
    ratios = []
    for score in scores:
        if score.quantity == "speed" and score.band is not None:
            low, high = (score.low, score.high) if estimates_alone else score.band
            inside.setdefault(score.swimmer, []).append(score.within(low, high))
            ratios.append(high / low)
    if not ratios:
        return math.nan, math.nan
    return float(np.mean([np.mean(part) for part in inside.values()])), float(np.median(ratios))


def swimmer_logs(ratios: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """Return the mean natural logarithm of each swimmer's ratios, without swimmers of which one is not positive."""
    return {name: float(np.mean(np.log(part))) for name, part in ratios.items() if all(ratio > 0 for ratio in part)}


def leave_one_out(logs: Mapping[str, float]) -> Array:
    """Return each logarithm less the mean of all others (swimmers,).

    This is the error left in a swimmer's prediction after a correction by one factor, fitted to the others.
    """
    values = np.array([*logs.values()])
    if len(values) < 2:
        return np.full(len(values), math.nan)
    differences: Array = values - (values.sum() - values) / (len(values) - 1)
    return differences


@dataclass(frozen=True)
class Scoreboard(Plotted, Tabular, data=lambda board: board.dataset()):
    """Published swimmers beside what first robots of them are predicted to do, and the laws that swimmers obey."""

    scores: tuple[Score, ...]
    others: Mapping[str, Sequence[Other]]  # by swimmer, of those with several speeds
    shoal: Shoal  # random fish

    @property
    def speeds(self) -> tuple[Score, ...]:
        """The scores of speeds."""
        return tuple(score for score in self.scores if score.quantity == "speed")

    def swum(self, speed: str) -> Shoal:
        """Return the runs of the swimmers as a `Shoal`.

        Parameters
        ----------
        speed : str
            Which speeds: "published" or "predicted"; the excursions are those predicted.

        Returns
        -------
        Shoal
        """
        columns = ("length", "frequency", speed, "excursion")
        return Shoal(*(np.array([getattr(score, name) for score in self.speeds]) for name in columns))

    def summary(self) -> dict[str, Quantity]:
        """Return statistics of the predictions by name, and of the laws that random fish obey.

        Returns
        -------
        dict of Quantity
        """
        predicted, own, fish = statistics(self.scores), statistics(self.scores, own=True), self.shoal
        left_out = leave_one_out(swimmer_logs(ratios_of(self.scores)))
        (inside, band_ratio), (alone, alone_ratio) = (coverage(self.scores, estimates_alone=a) for a in (False, True))
        others = [other for part in self.others.values() for other in part]
        rows: dict[str, tuple[Any, str | None]] = {
            "swimmers": (predicted.swimmers + predicted.missing, "swimmers with a speed"),
            "missing": (predicted.missing, "of these without a prediction"),
            "rms_log": (predicted.rms_log, "rms of the logarithm of predicted over published"),
            "mean_ratio": (predicted.mean_ratio, "geometric mean of predicted over published"),
            "within_1_3": (predicted.within_near, f"swimmers within a factor of {NEAR:g}"),
            "within_2": (predicted.within_far, f"swimmers within a factor of {FAR:g}"),
            "factor_of_nine_in_ten": (predicted.factor, "factor that holds for nine of ten"),
            "inside_band": (inside, "published speeds inside the 90 % band"),
            "band_ratio": (band_ratio, "median of the band, upper over lower end"),
            "inside_estimates": (alone, "inside the band of the robot's estimates alone"),
            "estimates_ratio": (alone_ratio, "median of that band, upper over lower end"),
            "own_swimmers": (own.swimmers, "swimmers with sections of their own"),
            "own_rms_log": (own.rms_log, "rms of their logarithm with these"),
            "own_mean_ratio": (own.mean_ratio, "geometric mean with these"),
            "left_out_rms_log": (_rms(left_out), "rms if the mean of the others corrected each"),
            "several_speeds": (len(self.others), "swimmers with several speeds"),
            "other_speeds": (len(others), "their other speeds, a drag area fitted to one"),
            "other_speeds_hold": (sum(other.holds for other in others), "of these within 10 % and the published error"),
            "fish": (len(fish.speed), "random fish"),
            "fish_settled": (int(np.isfinite(fish.speed).sum()), None),
            "fish_over_gazzola": (_median(fish.over_gazzola), "their Re over Gazzola's, median"),
            "fish_strouhal": (_median(fish.strouhal), "their Strouhal number, median"),
            "fish_stride_length": (_median(fish.stride), "their stride length in BL, median"),
        }
        return {name: Quantity(value, "", label) for name, (value, label) in rows.items()}

    def dataset(self) -> xr.Dataset:
        """Return the scores as a table.

        Returns
        -------
        xarray.Dataset
            One dimension, score: published and predicted numbers in the unit of each, band, ratio.
        """
        columns: dict[str, Any] = {"unit": ("score", np.array([UNITS[score.quantity] for score in self.scores]))}
        for name in (*Score.__dataclass_fields__, "ratio", "inside"):
            values = np.array([_cell(getattr(score, name)) for score in self.scores])
            columns[name] = ("score", values, SIZES.get(name, "1"), name.replace("_", " "))
        return dataset(columns, {}, {"hypertuna_version": version(), "isa": _core.isa()})

    def record(self) -> dict[str, Any]:
        """Return the JSON record.

        Returns
        -------
        dict
            Provenance, summary, and the scores with the verdict of each.
        """
        rows = [
            {key_of(name, SIZES.get(name, "")): value for name, value in asdict(s).items()}
            | {"unit": UNITS[s.quantity], "ratio": s.ratio, "band": s.band, "inside": s.inside, "verdict": s.verdict}
            for s in self.scores
        ]
        facts = {"hypertuna_version": version(), "isa": _core.isa()}
        others = {name: [other._asdict() for other in part] for name, part in self.others.items()}
        numbers = {key: quantity.value for key, quantity in self.summary().items()}
        return facts | numbers | {"scores": rows, "others": others}


def ratios_of(scores: Iterable[Score], *, own: bool = False) -> dict[str, list[float]]:
    """Return predicted over published speeds of runs, by swimmer; own: predicted with its published sections."""
    ratios: dict[str, list[float]] = {}
    for score in scores:
        if score.quantity == "speed" and (not own or math.isfinite(score.own)):
            ratios.setdefault(score.swimmer, []).append((score.own if own else score.predicted) / score.published)
    return ratios


def _rms(values: Array) -> float:
    """Return the root mean square of values; NaN if there are none."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan


def _median(values: Array) -> float:
    """Return the median of the values that are known."""
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else math.nan


def _cell(value: Any) -> Any:
    """Return a value as a cell of a table: NaN for none."""
    return math.nan if value is None else float(value) if isinstance(value, bool) else value
