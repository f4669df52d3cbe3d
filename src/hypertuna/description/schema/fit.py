"""The table [fit], which an identification writes into a robot description."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from hypertuna.description.schema.base import Amplitude, Check, Index, Part, Positive, Real, Text, entry


class Fitted(Part, table="fit", how="written by `hypertuna identify`"):
    """Result of an identification: values and their covariance, in SI units."""

    text: Text = entry("sentence that states what was fitted to what")
    trials: Text = entry("files of the trials")
    seed: Index = entry("seed of the fit", default=0)
    names: tuple[Text, ...] = entry("free coefficients, as `hypertuna identify --free` names them", min_length=1)
    units: tuple[str, ...] = entry("unit of each")
    scale: tuple[Literal["natural", "log"], ...] = entry("scale of each, in which its error is normally distributed")
    value: tuple[Real, ...] = entry("value of each")
    lower: tuple[Real, ...] = entry("lower bound of each")
    upper: tuple[Real, ...] = entry("upper bound of each")
    covariance: tuple[tuple[Real, ...], ...] = entry(
        "covariance of the values, or of their logarithms in log scale; the bounds are a weak prior"
    )
    frequency: tuple[Positive, ...] | None = entry("lowest and highest frequency of the runs", "Hz", default=None)
    amplitude: tuple[Amplitude, ...] | None = entry(
        "smallest and largest amplitude of the runs, of the joint group that moves most", "deg", default=None
    )
    speed: tuple[Real, ...] | None = entry("lowest and highest speed of the runs", "m/s", default=None)

    def _checks(self) -> Iterator[Check]:
        count = len(self.names)
        columns = {n: getattr(self, n) for n in ("units", "scale", "value", "lower", "upper", "covariance")}
        columns |= {f"covariance[{i}]": row for i, row in enumerate(self.covariance)}
        for name, column in columns.items():
            text, value = f"must be {count} long, like fit.names", f"{len(column)} long"
            yield Check(len(column) == count, name, text, "identify again", value)
        for i, (low, found, high) in enumerate(zip(self.lower, self.value, self.upper, strict=False)):
            text, slack = f"must be from lower to upper, {low:g} to {high:g}", 1e-9 * max(abs(low), abs(high))
            yield Check(low - slack <= found <= high + slack, f"value[{i}]", text, "identify again", f"{found:g}")
        for i, (low, scale) in enumerate(zip(self.lower, self.scale, strict=False)):
            yield Check(
                scale != "log" or low > 0, f"lower[{i}]", "must be greater than 0 in log scale", "identify again"
            )
        slack = 1e-6 * max((abs(x) for row in self.covariance for x in row), default=0.0)
        for i, row in enumerate(self.covariance):
            pairs = [(row[k], self.covariance[k][i]) for k in range(i) if k < len(row) and i < len(self.covariance[k])]
            valid = all(abs(a - b) <= slack for a, b in pairs) and min(row[i : i + 1], default=0.0) >= 0
            text = "must be a row of a covariance: symmetric, no variance below 0"
            yield Check(valid, f"covariance[{i}]", text, "identify again")
