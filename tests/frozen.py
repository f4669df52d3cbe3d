"""Values do not change once they are made: which dataclasses of a room do."""

import inspect
import pkgutil
from dataclasses import is_dataclass
from importlib import import_module


def changeable(room: str) -> list[str]:
    """Name the dataclasses of a room that are not frozen."""
    package = import_module(f"hypertuna.{room}")
    names = [one.name for one in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")]
    # of stable-baselines, which no extra has
    modules = [import_module(name) for name in (package.__name__, *names) if not name.endswith(".sb3")]
    classes = {kind for module in modules for kind in vars(module).values() if inspect.isclass(kind)}
    own = (
        kind for kind in classes if is_dataclass(kind) and kind.__module__ in {module.__name__ for module in modules}
    )
    return sorted(kind.__name__ for kind in own if not kind.__dataclass_params__.frozen)  # type: ignore[attr-defined]  # of is_dataclass
