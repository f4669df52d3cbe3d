"""Layout of results in shards: their columns, and the labeled dataset that they become."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.io.files import dataset

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Layout:
    """Dimensions, labels and facts of results in columns, an entry per item; the last dimension varies fastest."""

    sizes: Mapping[str, int]  # dimension -> size
    variables: Mapping[str, Mapping[str, Any]]  # column -> its attributes
    coordinates: Mapping[str, tuple[str, Any, Mapping[str, str]]]  # name -> dimension, labels, attributes
    facts: Mapping[str, Any]  # attributes of the dataset
    table: Mapping[str, str]  # of a CSV file, after the coordinates: variable -> head of its column

    def dataset(self, columns: Mapping[str, Array]) -> xr.Dataset:
        """Return columns, each with an entry per item, as a labeled dataset."""
        dims, shape = tuple(self.sizes), tuple(self.sizes.values())
        variables = {name: (dims, values.reshape(shape), self.variables[name]) for name, values in columns.items()}
        labels = {name: (dim, np.array(values), about) for name, (dim, values, about) in self.coordinates.items()}
        return dataset(variables, labels, dict(self.facts))

    @property
    def heads(self) -> dict[str, str]:
        """Columns of a CSV file, as `variable_columns` takes them."""
        names = (name for name, (_, _, attributes) in self.coordinates.items() if "same_as" not in attributes)
        return {name: name for name in names} | dict(self.table)


NO_LAYOUT = Layout({}, {}, {}, {}, {})  # before the first shard is known
