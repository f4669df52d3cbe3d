"""Robot image: all of a robot's numbers that the core needs, as columns in one file that any host can read.

`hosts/image.hpp` reads what `pack` writes; the layout is described there. `mission/image.py` adds pilot and missions.
"""

import itertools
import json
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from hypertuna import _core
from hypertuna.arrays import Array
from hypertuna.control.sensors import sensor_columns
from hypertuna.description.robot import Robot
from hypertuna.description.schema.water import LAWS
from hypertuna.description.twin import require_controller, why_no_twin
from hypertuna.io.files import version
from hypertuna.simulation.image_body import body_facts
from hypertuna.simulation.image_text import body_text, numbers_of_text, robot_facts
from hypertuna.simulation.plant import controller_of, parts_of, plant_columns, steps_of
from hypertuna.simulation.sea import Sea, sea_columns
from hypertuna.swimming.model import model_columns
from hypertuna.swimming.yielding import SPRING, hinge_links, spring_of

MAGIC = b"HTROBOT\0"  # first bytes of every robot image


def twin_image(robot: Robot, added: Mapping[str, Any], facts: Mapping[str, Any]) -> bytes:
    """Return the image of a robot's models in water, and of its twin if it has one.

    `added` columns replace those of the same name; `facts` are added to the text.
    """
    models = list(_models(robot))
    body, source = body_facts(robot, models, _numbers, _steps)
    text = {"made_by": f"hypertuna {version()}"} | robot_facts(robot, models) | {"body": body, "source": source.text}
    json_text = json.dumps(text | dict(facts), ensure_ascii=False, separators=(",", ":"))
    return pack(_columns(robot, models) | dict(added), json_text)


def _columns(robot: Robot, models: Iterable[Robot]) -> dict[str, Any]:
    """Return all columns of a robot's image, by name."""
    columns = _model_columns(robot, models)
    if not why_no_twin(robot):
        columns |= {f"plant.{name}": value for name, value in plant_columns(robot).items()}
        columns |= {f"controller.{name}": value for name, value in controller_of(robot).items()}
        columns |= {f"sensors.{name}": value for name, value in sensor_columns(robot).items()}
        columns |= {f"world.{name}": value for name, value in sea_columns(robot, Sea()).items()}
        columns |= {"run.steps": _steps(robot)}
    return columns


def _steps(robot: Robot) -> int:
    """Return the number of the twin's integration steps per tick of its controller."""
    return steps_of(1 / require_controller(robot).rate, parts_of(robot, "water", None), robot)


def _model_columns(robot: Robot, models: Iterable[Robot]) -> dict[str, Any]:
    """Return the columns of a robot's models in water, with names ``models.K.NAME``."""
    columns: dict[str, Any] = {}
    for k, model in enumerate(models):
        law = list(dict(_core.water_laws())).index(model.model.water)
        own = model_columns(model, {}) | {"law": law, "robot_mass": robot.body.mass} | spring_columns(robot)
        columns |= {f"models.{k}.{name}": value for name, value in own.items()}
    return columns


def spring_columns(robot: Robot) -> dict[str, list[float]]:
    """Return the columns of the springs in a robot's passive hinges; none without hinges."""
    springs = [{"link": link} | spring_of(hinge) for link, hinge in zip(hinge_links(robot), robot.hinges, strict=True)]
    return {f"spring.{name}": [spring[name] for spring in springs] for name in ("link", *SPRING) if springs}


def _numbers(robot: Robot) -> dict[str, Array]:
    """Return all numbers of a robot's image and of its text by name, each as a flat array."""
    columns = _columns(robot, _models(robot))
    rows = {name: np.asarray(value, dtype=np.float64).ravel() for name, value in columns.items()}
    return rows | {f"text.{name}": np.array([value]) for name, value in numbers_of_text(body_text(robot))}


def pack(columns: Mapping[str, Any], text: str) -> bytes:
    """Return an image as bytes, from columns of numbers with one or two dimensions and a text."""
    arrays = {name: np.atleast_1d(np.asarray(value, dtype="<f8")) for name, value in columns.items()}
    names = [name.encode() for name in arrays]
    shapes = [(len(array), *array.shape[1:], *(1,) * (2 - array.ndim)) for array in arrays.values()]
    entries = b"".join(struct.pack("<3I", *shape, len(name)) for shape, name in zip(shapes, names, strict=True))
    numbers = np.concatenate([array.ravel() for array in arrays.values()])
    encoded = text.encode()
    sizes = struct.pack("<4I", len(arrays), sum(map(len, names)), len(encoded), len(numbers))
    tables = entries + b"".join(names) + encoded
    body = sizes + tables + bytes(-len(tables) % 8) + numbers.tobytes()
    return MAGIC + struct.pack("<2I", _core.IMAGE_VERSION, zlib.crc32(body)) + body


def _models(robot: Robot) -> Iterator[Robot]:
    """Yield the robot with each combination of water law and joint model, its own choice first."""
    yield robot
    chosen = (robot.model.water, robot.model.joints)
    waters = [water for water in LAWS if getattr(robot.water, water) is not None]
    joint_models = ["ideal"] if any(group.bandwidth is None for group in robot.joints) else ["bandwidth", "ideal"]
    for water, joints in itertools.product(waters, joint_models):
        if (water, joints) != chosen:
            # as `using` does, but without the checks of a file, since bodies with many factors are tried
            choice = robot.model.model_copy(update={"water": water, "joints": joints})
            yield robot.model_copy(update={"model": choice})
