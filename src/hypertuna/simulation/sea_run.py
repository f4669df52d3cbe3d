"""Record of a run of the twin at sea, and the motion of its head."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.display import Plotted
from hypertuna.frames import angles_of, rotation_of
from hypertuna.simulation.recorded import VARIABLES as INNER
from hypertuna.simulation.recorded import Variables
from hypertuna.simulation.run import Run
from hypertuna.simulation.sea import Sea

if TYPE_CHECKING:
    import xarray as xr

PLANAR = ("x", "y", "heading", "speed", "sway", "yaw")  # quantities of the head that only a planar run records

# By name of a quantity recorded at sea: dimension in addition to time, unit and meaning. The rest is as in the plane.
VARIABLES: Variables = {
    "position": ("axis", "m", "position of the nose: east, north, up, the surface at zero"),
    "attitude": ("quaternion", "1", "unit quaternion w, x, y, z from body axes to east, north, up"),
    "velocity": ("axis", "m/s", "velocity of the nose through the water in body axes: aft, starboard, up"),
    "turn_rate": ("axis", "rad/s", "rate of turn of the head in body axes"),
    "fin": ("side", "rad", "angle of the pectoral fins, leading edge up"),
    "fin_target": ("side", "rad", "target angle of the fins' servos"),
    "rate_measured": ("axis", "rad/s", "reading of the gyroscope"),
    "acceleration_measured": ("axis", "m/s^2", "reading of the accelerometer"),
    "charge": ("", "C", "charge taken from the battery, at the end of the control tick"),
    **{name: label for name, label in INNER.items() if name not in PLANAR},
}


class Motion:
    """Motion of the head in a record at sea."""

    data: dict[str, Array]  # by the names of `VARIABLES`; has "position", "attitude" and "velocity"

    @property
    def position(self) -> Array:
        """Position of the nose (T, 3): east, north, up [m]."""
        return self.data["position"]

    @property
    def depth(self) -> Array:
        """Depth of the nose (T,) [m]."""
        result: Array = -self.position[:, 2]
        return result

    @property
    def attitude(self) -> Array:
        """Unit quaternions (T, 4), w, x, y, z, from body axes to east, north, up [1]."""
        return self.data["attitude"]

    @cached_property
    def angles(self) -> Array:
        """Roll, pitch and heading (T, 3): starboard down, nose up, clockwise from north, unwrapped [rad]."""
        return np.unwrap(angles_of(self.attitude), axis=0)

    @property
    def roll(self) -> Array:
        """Roll (T,), starboard down [rad]."""
        return np.asarray(self.angles[:, 0])

    @property
    def pitch(self) -> Array:
        """Pitch (T,), nose up [rad]."""
        return np.asarray(self.angles[:, 1])

    @property
    def heading(self) -> Array:
        """Heading (T,), clockwise from north, unwrapped [rad]."""
        return np.asarray(self.angles[:, 2])

    @property
    def speed(self) -> Array:
        """Velocity of the nose through the water, ahead along the head's axis (T,) [m/s]."""
        result: Array = -self.data["velocity"][:, 0]
        return result


@dataclass(frozen=True)
class SeaRun(Run, Motion, Plotted):
    """A run of the twin at sea."""

    sea: Sea

    @cached_property
    def sink(self) -> Array:
        """Rate at which the nose moves down (T,) [m/s]."""
        result: Array = -np.einsum("tj,tj->t", rotation_of(self.attitude)[:, 2], self.data["velocity"])
        return result

    @property
    def every(self) -> int:
        """Number of ticks from one row of the record to the next."""
        return round((self.time[1] - self.time[0]) / self.tick) if len(self.time) > 1 else 1

    def averaged(self, values: Array) -> Array:
        """Return a moving average: the mean over a beat around each row, or over less near the ends.

        Parameters
        ----------
        values : ndarray, shape (T,)
            One of the run's [any unit].

        Returns
        -------
        ndarray, shape (T,)
            [the same unit].
        """
        half_beat = round(0.5 / (self.gait.frequency * self.tick * self.every))
        total = np.concatenate([[0.0], np.cumsum(values)])
        place = np.arange(len(values))
        reach = np.minimum(half_beat, np.minimum(place, len(values) - 1 - place))
        result: Array = (total[place + reach + 1] - total[place - reach]) / (2 * reach + 1)
        return result

    def dataset(self) -> xr.Dataset:
        """Return the record as a data set, with units and meanings in the attributes.

        Returns
        -------
        xarray.Dataset
        """
        labels = {"axis": "xyz", "side": ("port", "starboard"), "quaternion": "wxyz"}
        attributes = {"frequency_hz": self.gait.frequency, "seed": self.seed, "status": self.status}
        return self._labeled(VARIABLES, labels, attributes)
