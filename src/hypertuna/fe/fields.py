"""VTU files with the fields of a finite-element model, for ParaView and pictures: displacement, stress, strain."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.fe.energies import solid_energy
from hypertuna.fe.model import FeModel
from hypertuna.io.door import KINDS, read_bytes
from hypertuna.io.files import scratch, write_atomically

# Names of the fields in the files.
DISPLACEMENT, FACE = "displacement [m]", "face [1]"
STRESS, STRAIN = "von Mises stress [Pa]", "largest principal logarithmic strain [1]"

# Values of the field FACE by kind of face; -1: a face inside the body, between matrix and plates or at the strip.
FACE_NUMBERS = {"outer": 0, "symmetry": 1, "wall_left": 2, "wall_right": 3, "cap_left": 4, "cap_right": 5}
OF_PLATE = {"plate_outer": 6, "plate_symmetry": 7}
FACE_NUMBERS |= OF_PLATE
SMOOTH = 2  # polynomial order of stress and strain in the files
VOLUME_FINER, SURFACE_FINER = 1, 2  # how often elements are halved in the files of volumes and of surfaces
HEAD = 4096  # most bytes of a file before its numbers
NUMBERS = b'<AppendedData encoding="raw">\n_'  # text before the numbers; each array follows its length in four bytes
# An array in the head of a file: type, name, components and offset.
ARRAY = re.compile(
    rb'<DataArray type="(Float64|Int32|UInt8)" Name="([^"]+)"(?: NumberOfComponents="([13])")? '
    rb'format="appended" offset="(\d{1,9})">'
)
# NumPy types by type name in the files.
TYPES: dict[bytes, np.dtype[Any]] = {b"Float64": np.dtype("<f8"), b"Int32": np.dtype("<i4"), b"UInt8": np.dtype("u1")}
TRIANGLE, QUAD = 5, 9  # values in the array "types"
ROUND = 1e-24  # squared strain below rounding, added to avoid 0/0 in the undeformed state


def volume_path(folder: str | Path, k: int) -> Path:
    """Return the file of the fields inside the upper half at the k-th pressure."""
    return Path(folder) / f"volume-{k:03d}.vtu"


def surface_path(folder: str | Path, k: int) -> Path:
    """Return the path of the VTU file with the surface fields of the upper half at pressure k."""
    return Path(folder) / f"surface-{k:03d}.vtu"


def write_vtu(model: FeModel, folder: str | Path, k: int) -> None:
    """Write the fields of a model in equilibrium, inside the upper half and on its faces, with points at rest [m].

    Stress and strain are averaged over the elements at a point, so the maxima of `Measured` are higher.
    """
    import ngsolve as ngs

    averaged = {name: _smooth(model, field) for name, field in ((STRESS, _stress(model)), (STRAIN, _strain(model)))}
    fields = {DISPLACEMENT: model.displacement} | averaged
    _write(model.mesh, fields, volume_path(folder, k), ngs.VOL, VOLUME_FINER)
    plate = ngs.BoundaryFromVolumeCF(model.mesh.MaterialCF({"plate": 1.0}, default=0.0))
    of_matrix = {name: float(number) for name, number in FACE_NUMBERS.items() if name not in OF_PLATE}
    outer, symmetry = OF_PLATE["plate_outer"], OF_PLATE["plate_symmetry"]
    of_plate = {"outer": outer, "tip": outer, "symmetry": symmetry}
    face = ngs.IfPos(plate - 0.5, *(model.mesh.BoundaryCF(of_matrix | kinds, default=-1.0) for kinds in (of_plate, {})))
    _write(model.mesh, fields | {FACE: face}, surface_path(folder, k), ngs.BND, SURFACE_FINER)


def read_surface(path: str | Path) -> tuple[Array, NDArray[np.int32], NDArray[np.uint8], dict[str, Array]]:
    """Return from a file of faces: points (n, 3) [m], cells as in VTK, types of cells, and fields at the points.

    The file is checked here, since VTK trusts all sizes and indices in it.
    """
    content, arrays = read_bytes(path, "surface"), dict[str, Any]()
    header_end = content.find(NUMBERS, 0, HEAD) + len(NUMBERS)
    try:
        for kind, name, width, offset in ARRAY.findall(content, 0, header_end) if header_end >= len(NUMBERS) else ():
            start = header_end + int(offset) + 4
            count = int.from_bytes(content[start - 4 : start], "little") // TYPES[kind].itemsize
            values = np.frombuffer(content, TYPES[kind], count, start)
            arrays[name.decode()] = values.reshape(-1, 3) if width == b"3" else values
        points, corners, ends, types = (arrays[name] for name in ("Points", "connectivity", "offsets", "types"))
        fields = {name: arrays[name] for name in (DISPLACEMENT, FACE, STRESS, STRAIN)}
        sizes, integers = (
            np.where(types == QUAD, np.int32(4), np.int32(3)),
            (corners.dtype.kind, ends.dtype.kind) == ("i", "i"),
        )
        faces = np.isin(types, (TRIANGLE, QUAD)).all() and np.array_equal(ends, np.cumsum(sizes, dtype=np.int32))
        corners_fit = len(corners) == sizes.sum() > 0 and corners.min() >= 0 and corners.max() < len(points)
        shapes_fit = [values.ndim for values in (points, *fields.values())] == [2, 2, 1, 1, 1]
        values_fit = all(len(values) == len(points) for values in fields.values()) and np.isfinite(points).all()
        fits = integers and faces and corners_fit and shapes_fit and values_fit
        if not (fits and np.abs(fields[FACE]).max() <= len(FACE_NUMBERS)):
            raise ValueError
    except (ValueError, KeyError):
        raise InputError("must be a whole surface", file=str(path), fix=KINDS["surface"].fix) from None
    cells = np.empty(len(corners) + len(sizes), dtype=np.int32)  # each face: number of corners, then the corners
    counts = np.zeros(len(cells), dtype=bool)
    counts[ends - sizes + np.arange(len(sizes), dtype=np.int32)] = True
    cells[counts], cells[~counts] = sizes, corners
    return points, cells, types, fields


def _write(mesh: Any, fields: dict[str, Any], path: Path, where: Any, finer: int) -> None:
    """Write fields on elements or faces as a VTU file, whole or not at all."""
    from ngsolve import VTKOutput

    with scratch() as folder:
        draft = folder / "draft"
        names, options = list(fields), {"subdivision": finer, "legacy": False, "floatsize": "double"}
        VTKOutput(mesh, coefs=list(fields.values()), names=names, filename=str(draft), **options).Do(vb=where)
        write_atomically(path, draft.with_suffix(".vtu").read_bytes())


def _smooth(model: FeModel, field: Any) -> Any:
    """Return a continuous field of the matrix: the best fit in each element, averaged between elements."""
    import ngsolve as ngs

    matrix = model.mesh.Materials("matrix")
    smooth = ngs.GridFunction(ngs.H1(model.mesh, order=SMOOTH, definedon=matrix))
    smooth.Set(field.Compile(), definedon=matrix)
    return smooth


def _stress(model: FeModel) -> Any:
    """Return the von Mises stress [Pa] of the true stress in the matrix."""
    from ngsolve import Det, Grad, Id, InnerProduct, Trace, sqrt

    F = Id(3) + Grad(model.displacement)
    variable = F.MakeVariable()
    cauchy = solid_energy(model.matrix, variable).Diff(variable) * F.trans / Det(F)
    deviator = cauchy - Trace(cauchy) / 3 * Id(3)
    return sqrt(1.5 * InnerProduct(deviator, deviator))


def _strain(model: FeModel) -> Any:
    """Return the largest logarithmic strain, from the largest eigenvalue of F'F by the trigonometric cubic formula."""
    from ngsolve import Det, Grad, Id, IfPos, InnerProduct, Trace, acos, cos, log, sqrt

    F = Id(3) + Grad(model.displacement)
    C = F.trans * F
    mean = Trace(C) / 3
    deviator = C - mean * Id(3)
    radius = sqrt(InnerProduct(deviator, deviator) / 6 + ROUND)
    cosine = Det(deviator) / (2 * radius**3)
    angle = acos(IfPos(cosine - 1, 1.0, IfPos(-1 - cosine, -1.0, cosine))) / 3
    return log(mean + 2 * radius * cos(angle)) / 2
