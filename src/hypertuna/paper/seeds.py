"""Numbers over seeds of the noise, stored in data/seeds with their provenance, and computed again in full.

python -m hypertuna.paper.seeds                 # compute and store all studies, about 20 min of one core
python -m hypertuna.paper.seeds postures dives  # some of them
"""

import hashlib
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from statistics import median_low
from typing import Any, TypeAlias

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.channels import CHANNELS
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.io.files import shipped, write_atomically
from hypertuna.paper.computed import THREADS
from hypertuna.paper.ledger import Class, Finding
from hypertuna.paper.studies import STUDIES

SEEDS = tuple(range(32))
DIGITS = 6  # significant digits of stored numbers
AGAIN = "`hypertuna paper --full` computes it again"  # which command repeats stored results, for reasons
Numbers: TypeAlias = Mapping[str, Array]  # name -> its value for each seed (seeds,)


@dataclass(frozen=True)
class Stored:
    """The numbers of a study over seeds."""

    study: str
    robot: Robot
    record: Mapping[str, Any] | None  # None where there is no valid one
    reason: str = ""  # why there is none; without a full stop

    @cached_property
    def numbers(self) -> Numbers:
        """Values by name (seeds,); arrays of ones without a record, from which `finding` makes no number."""
        if self.record is None:
            return defaultdict(lambda: np.ones(len(SEEDS)))
        return {name: np.array(values) for name, values in self.record["numbers"].items()}

    def finding(self, key: str, model: str, class_: Class, values: Array, note: str) -> Finding:
        """Return a finding with the median of its values (seeds,); without a number where there is no record."""
        if self.record is None:
            return Finding(key, model, class_, None, self.reason)
        numbers = tuple(float(value) for value in values)
        return Finding(key, model, class_, median_low(numbers), note, values=numbers)


def read_seeds(study: str, robot: Robot) -> Stored:
    """Return a stored study; without a record if the robot has changed since."""
    try:
        record = json.loads(_path(study, robot).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return Stored(study, robot, None, f"no seeds of {robot.name} are stored; {AGAIN}")
    if record["taken_hash"] != taken_hash(robot):
        return Stored(study, robot, None, f"stale: {robot.name} has changed since its seeds were stored; {AGAIN}")
    return Stored(study, robot, record)


def compute_seeds(study: str, robot: Robot) -> Stored:
    """Compute a study over all seeds, store it, and return it."""
    with ThreadPoolExecutor(THREADS) as pool:
        rows = list(pool.map(lambda seed: STUDIES[study].run(robot, seed), SEEDS))
    numbers = {name: [float(f"{row[name]:.{DIGITS}g}") for row in rows] for name in rows[0]}
    made_by = {key: provenance(robot)[key] for key in ("hypertuna_version", "isa", "robot", "robot_hash")}
    origin = made_by | {
        "taken_hash": taken_hash(robot),
        "command": f"python -m hypertuna.paper.seeds {study}",
        "seeds": list(SEEDS),
    }
    record = {"study": study} | origin | {"numbers": numbers}
    lines = [f" {json.dumps(name)}: {json.dumps(values)}" for name, values in numbers.items()]
    opening = json.dumps(record | {"numbers": None}, indent=0).removesuffix("null\n}")
    write_atomically(_path(study, robot), (opening + "{\n" + ",\n".join(lines) + "\n}\n}\n").encode())
    return Stored(study, robot, record)


def all_seeds(*, full: bool = False, step: Callable[[], None] | None = None) -> dict[str, Stored]:
    """Return all studies by name; in full compute them again."""
    studies = {}
    for study, plan in STUDIES.items():
        studies[study] = (compute_seeds if full else read_seeds)(study, plan.robot())
        if full and step is not None:
            step()
    return studies


def taken_hash(robot: Robot) -> str:
    """Return the SHA-256 of a robot's values that the twin uses, without water laws other than the chosen one."""
    others = {"description", "sources", "guidance", "firmware"}  # no study has a pilot
    content = robot.model_dump(mode="json", by_alias=True, exclude_none=True, exclude=others)
    content["sensors"] = [part for part in content["sensors"] if not CHANNELS[part["quantity"]].pilot]
    content["water"] = {key: content["water"][key] for key in ("density_kg_m3", robot.model.water)}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _path(study: str, robot: Robot) -> Any:
    """Return the path of the file of a study."""
    return shipped("data/seeds") / f"{study}-{robot.name}.json"


def main() -> None:
    """Compute and store the studies named on the command line, or all."""
    for study in sys.argv[1:] or STUDIES:
        stored = compute_seeds(study, STUDIES[study].robot())
        print(f"stored: {_path(study, stored.robot)}")


if __name__ == "__main__":
    main()
