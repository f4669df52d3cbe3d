"""Importers: write manifests for published data sets of tracked runs, whose files stay unchanged."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError
from hypertuna.ranges import check_name

ANGLES, POSES = (
    "deg_hardware_motor_angles.csv",
    "deg_hardware_trajectories.csv",
)  # ends of the robot eel's file names, after the amplitude
EEL = "RoboticExplorationLab/RoboticSwimmingWithUnifiedFluidRobot"  # GitHub repository of the robot eel's data
# 122 cm by 122 cm, start in the middle. Closer to a wall than the robot's height, the water is not open.
EEL_TANK = {"x_m": [0.0, 1.22], "y_m": [0.0, 1.22], "wall_distance_m": 0.0935}


def import_folder(folder: str | Path, format: str = "rexeel", *, relative_to: Path | None = None) -> dict[str, Any]:
    """Return the document of a manifest for a folder of published files, with absolute or relative paths."""
    check_name(format, FORMATS, "format", "format")
    try:
        files = sorted(path.name for path in Path(folder).iterdir())
    except (OSError, ValueError):
        value = "a file" if os.path.exists(folder) else "missing"
        raise InputError("must be a folder", file=str(folder), value=value, fix="check the path") from None
    place = Path(folder).resolve()
    if relative_to is not None and place.is_relative_to(relative_to.resolve()):
        place = place.relative_to(relative_to.resolve())
    return FORMATS[format](str(folder), files, place)


def manifest_text(document: Mapping[str, Any], comment: str) -> str:
    """Return the document of a manifest as TOML."""
    import tomlkit  # imported here: slow to import

    return f"# {comment}\n{tomlkit.dumps(document)}"


def _rexeel(folder: str, files: list[str], place: Path) -> dict[str, Any]:
    """Return the manifest of a robot eel's free swims, whose yaw is clockwise from -x: 90 deg faces +y.

    It uses the commanded angles, since the servos report theirs late.
    """
    amplitudes = {name.removesuffix(end) for name in files for end in (ANGLES, POSES) if name.endswith(end)}
    if not amplitudes:
        fix = f"give a CSV file, a manifest, or the folder with *{ANGLES} and *{POSES} of {EEL}"
        raise InputError("holds no known published files", file=folder, fix=fix)
    for name in (f"{amplitude}{end}" for amplitude in amplitudes for end in (ANGLES, POSES)):
        if name not in files:
            file, fix = str(Path(folder) / name), "get it from the source of the others"
            raise InputError("must be there", file=file, value="missing", fix=fix)
    recordings = [
        {
            "name": f"{amplitude}deg",
            "begin": "rest",
            "joints": {
                "file": str(place / f"{amplitude}{ANGLES}"),
                "time": "time_s",
                "columns": [f"actual_{joint}" for joint in range(1, 6)],
                "targets": [f"target_{joint}" for joint in range(1, 6)],
                "use": "targets",
                "unit": "deg",
            },
            "poses": {
                "files": [str(place / f"{amplitude}{POSES}")],
                "time": "timestamp",
                "x": "x_cm",
                "y": "y_cm",
                "yaw": "robot_yaw",
                "run": "video",
                "length_unit": "cm",
                "angle_unit": "deg",
                "yaw_zero_deg": 180.0,
                "clockwise": True,
            },
        }
        for amplitude in sorted(amplitudes, key=lambda text: (len(text), text))
    ]
    return {"format": 1, "tank": EEL_TANK, "recordings": recordings}


FORMATS: dict[str, Callable[[str, list[str], Path], dict[str, Any]]] = {"rexeel": _rexeel}
