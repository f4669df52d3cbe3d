"""A number of a result as users read it."""

from __future__ import annotations

from typing import Any, NamedTuple


class Quantity(NamedTuple):
    """One line of a result's summary: what the terminal's table and the JSON object say."""

    value: Any  # in `unit`
    unit: str  # empty without one
    label: str | None  # on the terminal; empty: the quantity above in another unit; None: not on the terminal
