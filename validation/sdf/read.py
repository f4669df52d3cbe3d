"""Read SDF files by libsdformat, Gazebo's own parser, as Drake has it; it refuses elements that the format has not."""

from __future__ import annotations

import argparse
from pathlib import Path


def read(text: str) -> str:
    """Return Drake's summary of a file, or its reason for refusing it."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(time_step=0.0)
    try:
        Parser(plant).AddModelsFromString(text, "sdf")
        plant.Finalize()
    except RuntimeError as error:
        return f"refused: {str(error).splitlines()[0]}"
    mass = plant.CalcTotalMass(plant.CreateDefaultContext())
    return f"read: {plant.num_bodies() - 1} links, {plant.num_velocities()} degrees of freedom, {mass:.4f} kg"


def main() -> None:
    """Read each file, and the same with an element renamed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    for file in parser.parse_args().files:
        text = file.read_text()
        print(f"{file.name}: {read(text)}")
        print(f"  renamed: {read(text.replace('<zq>', '<zw>').replace('</zq>', '</zw>'))}")


if __name__ == "__main__":
    main()
