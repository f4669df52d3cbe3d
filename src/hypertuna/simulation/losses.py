"""Losses: where the electrical power of a run of the twin goes, from the battery's cells to the water."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from hypertuna.actuation.battery import battery_columns
from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.io.quantity import Quantity
from hypertuna.ranges import check_choice
from hypertuna.simulation.recorded import LOSSES

MIN_SHARE = 5e-3  # fraction of the power below which a loss is not named
PLACES = ("battery", *dict.fromkeys(place for place, _ in LOSSES.values()))  # in the order in which power flows


class Loss(NamedTuple):
    """Power that is lost at one place for one reason."""

    name: str
    place: str  # one of `PLACES`
    power: float  # W, mean
    text: str


@dataclass(frozen=True)
class Losses(Plotted, Tabular, data=lambda losses: losses.rows):
    """Mean power losses over the last beats of a run; they add up to the power that the battery's cells give."""

    title: str  # robot and gait
    losses: tuple[Loss, ...]

    @property
    def power(self) -> float:
        """Mean power that the battery's cells give [W]."""
        return sum(loss.power for loss in self.losses)

    def at(self, place: str) -> float:
        """Return the total power lost at a place [W].

        Parameters
        ----------
        place : str
            One of "battery", "servos", "oil", "joints", "water".

        Returns
        -------
        float
            [W].
        """
        return sum(loss.power for loss in self._losses_at(place))

    def named(self, place: str) -> str:
        """Return the larger losses at a place as a text of names and powers [W]: ``windings 4.53, gears 1.87``.

        Parameters
        ----------
        place : str
            As of `at`.

        Returns
        -------
        str
        """
        losses = [
            loss for loss in self._losses_at(place) if loss.name != place and abs(loss.power) >= MIN_SHARE * self.power
        ]
        return ", ".join(f"{loss.name} {loss.power:.2f}" for loss in losses)

    def _losses_at(self, place: str) -> list[Loss]:
        """Return the losses at a place."""
        check_choice(place, PLACES, "place")
        return [loss for loss in self.losses if loss.place == place]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The losses as rows of a table."""
        return [
            {"name": name, "place": place, "power_w": power, "part": power / self.power, "meaning": text}
            for name, place, power, text in self.losses
        ]

    def summary(self) -> dict[str, Quantity]:
        """Return the power of the cells, the total of each place, and each single loss.

        Returns
        -------
        dict of str to Quantity
            By the keys of the JSON record.
        """
        places = {f"{place}_w": Quantity(self.at(place), "W", place) for place in PLACES}
        losses = {f"{loss.name}_w": Quantity(loss.power, "W", None) for loss in self.losses if loss.place != loss.name}
        return {"power_w": Quantity(self.power, "W", "power of the cells")} | places | losses


def losses_of(robot: Robot, title: str, data: dict[str, Array], rows: slice) -> Losses:
    """Return the mean losses over some rows of a run's record, `data`."""
    battery = battery_columns(robot)
    voltage, current = data["battery_voltage"][rows], data["battery_current"][rows]
    supplied = float((voltage * current).mean())
    heat, board = battery["resistance"] * float((current**2).mean()), battery["electronics"]
    converter_loss = supplied - board - float(data["power"][rows].mean())
    of_servos = (
        Loss(name, place, float(data[f"loss_{name}"][rows].mean()), text) for name, (place, text) in LOSSES.items()
    )
    losses = (
        Loss("resistance", "battery", heat, "inner resistance of the cells"),
        Loss("converter", "battery", converter_loss, "converter of the servos"),
        Loss("electronics", "battery", board, "board, sensors and radio"),
        *of_servos,
    )
    return Losses(title, losses)
