"""The list of the kinds of trials, from which all lists of trials, quantities and figures follow."""

from collections.abc import Iterable
from typing import Any

from hypertuna.trials.kind import Kind, Quantity
from hypertuna.trials.kind_decay import Glides, YawDecays
from hypertuna.trials.kind_numbers import Powers, Thrusts, Tows, Turns
from hypertuna.trials.kind_steady import Steady
from hypertuna.trials.kind_tracked import Tracked

KINDS: tuple[Kind[Any], ...] = (Steady(), Tracked(), Tows(), Thrusts(), Powers(), Turns(), Glides(), YawDecays())
QUANTITIES: dict[str, Quantity] = {quantity.name: quantity for kind in KINDS for quantity in kind.quantities}


def kind_of(trial: Any) -> Kind[Any]:
    """Return the kind of a trial."""
    return next(kind for kind in KINDS if isinstance(trial, kind.trial))


def rigid_in(kinds: Iterable[Kind[Any]]) -> str:
    """Return the kinds of trials in which hinges stay rigid as words, such as "tows and held thrusts"."""
    return " and ".join(f"{kind.label}s" for kind in kinds if not kind.hinges_bend)
