"""Pictures of a soft joint under pressure, deformed and colored by stress or strain, from the files of fields.py.

There are two views: the drive units inside a glass body, and the lower half, cut at the middle plane. Camera and color
scale are the same at all pressures.
"""

import io
import itertools
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.fe.bend import SUMMARY
from hypertuna.fe.extra import need_pictures
from hypertuna.fe.fields import DISPLACEMENT, FACE, FACE_NUMBERS, STRAIN, STRESS, read_surface, surface_path
from hypertuna.figures import FAINT, SEQUENCE, WIDTH, styled
from hypertuna.io.door import parse_json, read_bytes
from hypertuna.io.files import write_atomically

# Parts of a picture, each with its kinds of faces in the files.
PARTS = {
    "outer": ("outer",),
    "cut": ("symmetry",),
    "left": ("wall_left",),
    "right": ("wall_right",),
    "caps": ("cap_left", "cap_right"),
    "plate": ("plate_outer",),
    "plate_cut": ("plate_symmetry",),
}
VIEWS = {"units": (0.35, -0.75, 0.60), "cut": (0.45, -0.70, 1.20)}  # direction to the camera, x y z
SAME = 1e-7  # m, tolerance within which points of neighboring faces are merged
QUANTILE = 0.98  # the color scale ends at this quantile over the walls under pressure
MARGIN = 1.05  # height of the view over that of the body
PIXELS = 640  # height of a rendered view
FRAMES, FEWEST, FILM_DPI = 4, 3, 140  # filmstrip: most frames, least number of columns, resolution
PALETTE = 256  # colors of a written picture; dithering keeps files small

GLASS, LINE = "#8A99A3", 3.0
THIN, THICK, FADED = 0.13, 0.3, 0.45  # opacity of the glass body, of the glass plate, and of units without pressure
DEPTH = 6  # transparent layers that are rendered in order
MATT: dict[str, Any] = {"smooth_shading": True, "ambient": 0.5, "diffuse": 0.56, "specular": 0.1, "specular_power": 15}


class ColoredQuantity(NamedTuple):
    """A quantity that colors show."""

    field: str  # name of the field in the files
    label: str  # label of the color bar
    unit: float  # the label's unit in SI


QUANTITIES = {  # by name in the files of pictures
    "stress": ColoredQuantity(STRESS, "von Mises stress [kPa]", 1e3),
    "strain": ColoredQuantity(STRAIN, "largest principal logarithmic strain [1]", 1.0),
}


@dataclass(frozen=True)
class FinishedRun:
    """A joint at several pressures, read from the files of a finished run."""

    title: str
    side: str  # side under pressure
    pressure: Array  # (n,) gauge pressure [Pa]
    angle: Array  # (n,) bend toward that side [rad]
    faces: tuple[dict[str, Any], ...]  # faces of the upper half by kind, pyvista.PolyData with points at rest

    def text(self, k: int) -> str:
        """Return the k-th pressure and bend as text."""
        return f"{self.pressure[k] / 1e3:.4g} kPa: {np.degrees(self.angle[k]):.1f} deg"

    def top(self, quantity: str) -> float:
        """Return the upper end of a quantity's color scale [SI], from its field at the last pressure."""
        scale = QUANTITIES[quantity]
        largest = float(np.quantile(self.faces[-1][self.side][scale.field], QUANTILE)) / scale.unit
        return _round_up(largest) * scale.unit


def read_film(folder: str | Path) -> FinishedRun:
    """Read the files of a finished run: `SUMMARY`, and the fields at each pressure."""
    need_pictures()
    summary = Path(folder) / SUMMARY
    try:
        record = parse_json(read_bytes(summary, "stored"))
        side, steps = str(record["side"]), record["steps"]
        title = f"{record['robot']}, joint {record['joint']}, pressure on the {side} side"
        pressure = np.array([1e3 * step["pressure_kpa"] for step in steps])
        angle = np.radians([step["bend_deg"] for step in steps])
    except (OSError, ValueError, KeyError, TypeError):
        fix = "give the folder of a finished `hypertuna fe bend`"
        raise InputError("must be the summary of a run", file=str(summary), fix=fix) from None
    return FinishedRun(title, side, pressure, angle, tuple(_faces(surface_path(folder, k)) for k in range(len(steps))))


@styled
def draw_step(film: FinishedRun, k: int, quantity: str) -> Figure:
    """Draw both views of a quantity at the k-th pressure, side by side."""
    figure = Figure(figsize=(WIDTH, 0.5 * WIDTH), layout="constrained")
    left, right = figure.subplots(1, 2)
    for axes, view, text in (
        (left, "units", "drive units, faded without pressure"),
        (right, "cut", "lower half, cut at the middle plane"),
    ):
        axes.imshow(_render(film, k, view, quantity), interpolation="antialiased")
        axes.set_axis_off()
        axes.text(0.0, 0.0, text, transform=axes.transAxes, color=FAINT, fontsize=8)
    figure.suptitle(f"{film.title}, {film.text(k)}", x=0.01, ha="left", fontsize=10, fontweight="bold")
    _bar(figure, [left, right], film, quantity, location="right", shrink=0.8)
    return figure


@styled
def draw_filmstrip(film: FinishedRun, *, width: float = WIDTH) -> Figure:
    """Draw the cut view at all pressures, with a row for each of `QUANTITIES`; `width` in inches."""
    count, rows = len(film.faces), len(QUANTITIES)
    figure = Figure(figsize=(width, 0.4 + rows * (width / max(count, FEWEST) + 0.55)), layout="constrained")
    panels = figure.subplots(rows, count, squeeze=False)
    for row, quantity in zip(panels, QUANTITIES, strict=True):
        for k, axes in enumerate(row):
            axes.imshow(_render(film, k, "cut", quantity), interpolation="antialiased")
            axes.set_axis_off()
        _bar(figure, list(row), film, quantity, location="bottom", shrink=0.5, pad=0.02)
    for k, axes in enumerate(panels[0]):
        axes.set_title(film.text(k), fontsize=9, loc="center", fontweight="normal")
    figure.suptitle(film.title, x=0.01, ha="left", fontsize=10, fontweight="bold")
    return figure


def write_pictures(folder: str | Path, *, progress: Callable[[int, int], None]) -> None:
    """Write a picture of each quantity at every pressure of a finished run, and a filmstrip."""
    film = read_film(folder)
    pictures = list(itertools.product(range(len(film.faces)), QUANTITIES))
    for count, (k, quantity) in enumerate(pictures, 1):
        write_png(draw_step(film, k, quantity), Path(folder) / f"{quantity}-{k:03d}.png")
        progress(count, len(pictures))
    if film.pressure[-1] > 0:
        write_filmstrip(folder, Path(folder) / "filmstrip.png")


def write_filmstrip(folder: str | Path, path: str | Path) -> None:
    """Write the filmstrip of a finished run, about 1000 pixels wide."""
    film = read_film(folder)
    loaded = np.flatnonzero(film.pressure > 0)
    chosen = loaded[np.unique(np.linspace(0, len(loaded) - 1, min(FRAMES, len(loaded))).round().astype(int))]
    faces = tuple(film.faces[k] for k in chosen)
    selection = replace(film, pressure=film.pressure[chosen], angle=film.angle[chosen], faces=faces)
    write_png(draw_filmstrip(selection), path, dpi=FILM_DPI)


def write_png(figure: Figure, path: str | Path, *, dpi: int = 200) -> None:
    """Write a figure as a PNG file of 256 colors, whole or not at all."""
    from PIL import Image

    figure.set_dpi(dpi)
    canvas, packed = FigureCanvasAgg(figure), io.BytesIO()
    canvas.draw()
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
    palette = picture.quantize(PALETTE, method=Image.Quantize.MAXCOVERAGE)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(packed, format="PNG", optimize=True)
    write_atomically(path, packed.getvalue())


def _bar(figure: Figure, axes: list[Axes], film: FinishedRun, quantity: str, **place: Any) -> None:
    """Draw the color bar of a quantity."""
    scale = QUANTITIES[quantity]
    colors = ScalarMappable(Normalize(0, film.top(quantity) / scale.unit), SEQUENCE)
    bar = figure.colorbar(colors, ax=axes, extend="max", label=scale.label, aspect=30, **place)
    bar.outline.set_visible(False)


def _round_up(value: float) -> float:
    """Return the smallest round number that is not below a value, for a color scale; 1 for zero."""
    if value <= 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * power >= value * (1 - 1e-9))


def _faces(path: Path) -> dict[str, Any]:
    """Return the faces of the upper half by part, a key of `PARTS`, from a file of fields."""
    import pyvista as pv

    points, cells, types, fields = read_surface(path)
    surface = pv.UnstructuredGrid(cells, types, points)
    surface.point_data.update(fields)
    number = np.rint(surface.point_data_to_cell_data()[FACE]).astype(int)

    def part(kinds: tuple[str, ...]) -> Any:
        cells = np.isin(number, [FACE_NUMBERS[kind] for kind in kinds])
        joined = surface.extract_cells(cells).clean(tolerance=SAME)
        return joined.extract_surface(algorithm="dataset_surface").triangulate()

    return {name: part(kinds) for name, kinds in PARTS.items()}


def _render(film: FinishedRun, k: int, view: str, quantity: str) -> NDArray[np.uint8]:
    """Return a view at the k-th pressure as pixels (height, width, 3)."""
    import pyvista as pv

    if not os.environ.get("DISPLAY"):  # VTK would warn that there is no display
        from vtkmodules.vtkCommonCore import vtkLogger

        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    size, position, scale = _camera(film, view)
    plotter = pv.Plotter(off_screen=True, window_size=size, lighting=None)
    plotter.set_background("white")
    plotter.add_light(pv.Light(light_type="camera light", position=(-0.3, 0.5, 1.0), intensity=0.95))
    colors = {"clim": (0, film.top(quantity)), "cmap": SEQUENCE, "show_scalar_bar": False}
    colors["scalars"] = QUANTITIES[quantity].field
    for part, opacity, colored in _parts(film.faces[k], view, film.side):
        plotter.add_mesh(part, opacity=opacity, **(colors if colored else {"color": GLASS}), **MATT)
    edges = {"feature_edges": False, "manifold_edges": False, "non_manifold_edges": False}
    for part in (_whole(film.faces[k]["outer"]), film.faces[k]["cut"]):  # the outline of the body at rest
        outline = part.extract_feature_edges(boundary_edges=True, **edges)
        plotter.add_mesh(outline, color=FAINT, line_width=LINE, opacity=0.8)
    plotter.enable_parallel_projection()
    plotter.camera_position, plotter.camera.parallel_scale = position, scale
    plotter.enable_depth_peeling(DEPTH)
    plotter.enable_anti_aliasing("ssaa")
    picture: NDArray[np.uint8] = plotter.screenshot(return_img=True)
    plotter.close()
    return picture


def _parts(faces: dict[str, Any], view: str, side: str) -> list[tuple[Any, float, bool]]:
    """Return the deformed parts of a view, each with its opacity and whether it is colored or gray.

    Drive units without pressure are faded, so that they do not hide the units under pressure.
    """
    shape = {name: part.copy() for name, part in faces.items()}
    for part in shape.values():
        part.points = part.points + part[DISPLACEMENT]
    if view == "units":
        units = [(_whole(shape[name]), 1.0 if name == side else FADED, True) for name in SIDES]
        opacities = {"outer": THIN, "plate": THICK, "caps": 1.0}
        return units + [(_whole(shape[name]), opacity, False) for name, opacity in opacities.items()]
    lower = [(_mirrored(shape[name]), 1.0, True) for name in (*SIDES, "outer")]
    gray = [(_mirrored(shape[name]), 1.0, False) for name in ("plate", "caps")]
    upper = [(shape["outer"], THIN, False), (shape["plate"], THIN, False)]
    return [*lower, (shape["cut"], 1.0, True), *gray, (shape["plate_cut"], 1.0, False), *upper]


def _camera(film: FinishedRun, view: str) -> tuple[tuple[int, int], list[tuple[float, ...]], float]:
    """Return the size [pixels], camera position and scale that frame the body at rest and at the last pressure."""
    direction = np.array(VIEWS[view]) / np.linalg.norm(VIEWS[view])
    right = np.cross((0.0, 0.0, 1.0), direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    parts = [_whole(film.faces[-1][name]) for name in ("outer", "plate")]
    points = np.concatenate([place for part in parts for place in (part.points, part.points + part[DISPLACEMENT])])
    extents = np.array([((points @ axis).min(), (points @ axis).max()) for axis in (right, up)])
    middle = extents.mean(axis=1) @ np.stack([right, up])
    wide, high = np.diff(extents).ravel()
    position = middle + 10 * max(wide, high) * direction
    size = (round(PIXELS * wide / high), PIXELS)
    return size, [tuple(position), tuple(middle), tuple(up)], float(MARGIN * high / 2)


def _mirrored(part: Any) -> Any:
    """Return the lower half of a part: the mirror image of the upper half."""
    lower = part.reflect((0, 0, 1), point=(0, 0, 0))
    lower[DISPLACEMENT] = part[DISPLACEMENT] * (1, 1, -1)
    return lower


def _whole(part: Any) -> Any:
    """Return both halves of a part as one."""
    return part.merge(_mirrored(part), merge_points=True)
