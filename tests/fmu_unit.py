"""An instance of an FMU, by FMPy, as the tests of FMUs step it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.model_description import ModelDescription

from hypertuna.arrays import Array

TICK = 0.01  # s


class Unit:
    """An instance of an FMU, by FMPy."""

    def __init__(self, path: Path, token: str | None = None, **start: Any) -> None:
        self.folder, self.said = fmpy.extract(str(path)), list[str]()
        self.about: ModelDescription = fmpy.read_model_description(self.folder)
        self.two = self.about.fmiVersion == "2.0"
        if token is not None:
            self.about.guid = self.about.instantiationToken = token
        self.variables = {one.name: one for one in self.about.modelVariables}
        self.unit: Any = fmpy.instantiate_fmu(self.folder, self.about, logger=self._log if self.two else self._log3)
        self.set(**start)
        if self.two:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()
        self.time = 0.0  # s

    def _log(self, environment: object, instance: object, status: int, category: bytes, message: bytes) -> None:
        self.said.append(message.decode())

    def _log3(self, environment: object, status: int, category: bytes, message: bytes) -> None:
        self.said.append(message.decode())

    def _call(self, verb: str, name: str, *values: Any) -> Any:
        two = {"Float64": "Real", "Int32": "Integer"}
        kind = self.variables[name].type
        kind = two.get(kind, kind) if self.two else kind
        return getattr(self.unit, f"{verb}{kind}")([self.variables[name].valueReference], *([v] for v in values))

    def set(self, **values: Any) -> None:
        """Set variables."""
        for name, value in values.items():
            self._call("set", name, value)

    def get(self, *names: str) -> Array:
        """Get variables."""
        return np.array([self._call("get", name)[0] for name in names])

    def step(self, size: float = TICK, at: float | None = None) -> None:
        """Make a step."""
        at = self.time if at is None else at
        self.unit.doStep(at, size)
        self.time = at + size

    def close(self) -> None:
        """End."""
        self.unit.terminate()
        self.unit.freeInstance()
