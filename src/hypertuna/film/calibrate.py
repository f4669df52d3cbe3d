"""Calibrate a camera: its lens from a film of a checkerboard, its pose from its height and corners of the tank."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError
from scipy.optimize import least_squares

from hypertuna.arrays import Array
from hypertuna.description.mistakes import translate
from hypertuna.errors import InputError
from hypertuna.film.camera import Camera
from hypertuna.film.numbers import read_rows
from hypertuna.film.source import Film, open_film
from hypertuna.io.extras import need
from hypertuna.ranges import CELL, Range
from hypertuna.trials.markers import PARTS

COLUMNS = ("u_px", "v_px", "x_m", "y_m")  # of a file of corners
MAX_BOARDS = 20  # views of the board that are used; the search stops there
MIN_BOARDS = 5  # views of the board that are needed
MIN_CORNERS = 4  # points of the tank that are needed
REFUSED, DOUBTFUL = 0.01, 0.0015  # rms residuals over the picture's width that are refused, or give a warning
FOCAL = Range(min=0.2, max=10)  # picture widths: angles of view of 136 to 6 deg


def calibrate(
    *,
    size: tuple[int, int] | None = None,
    board: str | Path | None = None,
    squares: tuple[int, int] = (9, 6),
    corners: str | Path | None = None,
    corner_depth: float = 0.0,
    height: float,
    focal: float | None = None,
    lens_k1: float = 0.0,
    refractive_index: float = 1.333,
) -> tuple[Camera, dict[str, Any]]:
    """Return a camera and a report: number of views of the board, number of corners, rms residuals [px], warnings.

    board: film of a checkerboard in air; squares: number of its inner corners along both sides. Without a board, size
    is that of the picture [px], and focal [px] and lens_k1 describe the lens. corners: CSV file with the pixels and
    places [m] of at least four points of the tank at `corner_depth` [m]; without them the camera looks straight down.
    height: of the camera over the water [m].
    """
    report: dict[str, Any] = {}
    if board is not None:
        film = open_film(board)
        size = film.width, film.height
        focal, center, lens_k1, report = _lens(film, squares)
    elif size is None:
        raise InputError("must be given", key="--size", fix="give the size of the film's frames, or a film of a board")
    else:
        center = (size[0] - 1) / 2, (size[1] - 1) / 2
    values = {"width_px": size[0], "height_px": size[1], "lens_k1": lens_k1, "center_px": center}
    values |= {"refractive_index": refractive_index}
    if corners is None:
        if focal is None:
            fix = "film a checkerboard, or give the corners of the tank"
            raise InputError("must be given without board and corners", key="--focal", fix=fix)
        _check_focal(focal, size[0], "--focal", "give it in pixels, not in mm")
        return _camera(values | {"focal_px": focal, "place_m": (0.0, 0.0, height)}), report
    pixels, places = read_corners(corners)
    _check_pixels(pixels, size, str(corners))
    camera, residual = _posed(values, pixels, places, corner_depth, height, focal, str(corners))
    rms = float(np.sqrt((residual**2).sum(axis=1).mean()))
    fix = "are the places of the points in m, and the height over the water, too?"
    _check_focal(camera.focal, size[0], "the focal length", fix if focal is None else "give it in pixels, not in mm")
    rule, causes = "must meet a camera's rays", "is each pixel beside its own point, in m? Are size and depth right?"
    if rms > REFUSED * size[0]:
        value = f"{rms:.3g} px off in the mean"
        raise InputError(rule, file=str(corners), key="the points", value=value, fix=causes)
    report |= {"corners": len(pixels), "corner_rms_px": rms}
    if rms > DOUBTFUL * size[0]:
        report["warnings"] = [f"The points are {rms:.2g} px off in the mean: {causes}"]
    return camera, report


def _check_focal(focal: float, width: int, key: str, fix: str) -> None:
    """Check that a focal length [px] gives a possible angle of view in a picture of that width [px]."""
    if focal / width not in FOCAL:
        rule = f"must be from {FOCAL.min:g} to {FOCAL.max:g} times the picture's width of {width} px"
        raise InputError(rule, key=key, value=f"{focal:.4g} px", fix=fix)


def _check_pixels(pixels: Array, size: tuple[int, int], file: str) -> None:
    """Check that points (n, 2) [px] are distinct ones of a picture of that size [px]."""
    outside = ((pixels < -0.5) | (pixels > np.array(size) - 0.5)).any(axis=1)
    if outside.any():
        rule, value = f"must lie in the picture of {size[0]} x {size[1]} px", f"{pixels[outside][0].tolist()}"
        fix = "give the size of the film's frames, width first, and pixels of such a frame"
        raise InputError(rule, file=file, key="the points", value=value, fix=fix)
    if np.ptp(pixels, axis=0).min() <= PARTS:
        rule, value = "must be pixels", "close together: parts of the picture's width and height?"
        raise InputError(
            rule, file=file, key="u_px and v_px", value=value, fix="give pixels from the first one's center"
        )
    if len(np.unique(pixels, axis=0)) < len(pixels):
        raise InputError("must be distinct", file=file, key="the points", value="given twice", fix="remove the repeat")


def read_corners(path: str | Path) -> tuple[Array, Array]:
    """Read points of the tank from a CSV file: pixels (n, 2) and places (n, 2) [m]."""
    rows = read_rows(path, COLUMNS, CELL, "give pixels and meters of each point")
    if len(rows) < MIN_CORNERS:
        rule, fix = f"must have {MIN_CORNERS} points of the tank at least", "add the other corners"
        raise InputError(rule, file=str(path), value=f"{len(rows)}", fix=fix)
    return rows[:, :2], rows[:, 2:]


def _camera(values: dict[str, Any]) -> Camera:
    """Check the values of a camera file and return the camera."""
    try:
        return Camera.model_validate(values)
    except ValidationError as error:
        raise translate(error, values, Camera, "the camera") from None


def _posed(
    values: dict[str, Any], pixels: Array, places: Array, depth: float, height: float, focal: float | None, file: str
) -> tuple[Camera, Array]:
    """Fit the camera's pose so that it sees points of the tank at their pixels; return it and the residuals [px]."""
    middle, spread = places.mean(axis=0), pixels - pixels.mean(axis=0)
    centered = places - middle
    # the search starts from the rotation and scale that best map pixels (y down) to places
    image = (spread[:, 0] - 1j * spread[:, 1])[:, np.newaxis]
    factor = complex(np.linalg.lstsq(image, centered[:, 0] + 1j * centered[:, 1], rcond=None)[0][0])
    if abs(factor) == 0 or np.linalg.matrix_rank(centered, tol=1e-6) < 2:
        raise InputError("must not lie on one line", file=file, key="the points", fix="give the corners of the tank")
    if np.linalg.det(np.linalg.lstsq(spread * [1, -1], centered, rcond=None)[0]) < 0:
        rule = "must not be mirrored: x, y and up are right-handed"
        fix = "is each pixel beside its own point, v from the top? Else film without a mirror, not as a selfie, or "
        fix += "mirror the film back (ffmpeg -vf hflip), or swap x and y"
        raise InputError(rule, file=file, key="the points", fix=fix)
    start = np.array([middle[0], middle[1], 0.0, 0.0, np.angle(factor), 0.0])
    first_focal = height / abs(factor) if focal is None else focal

    def camera(x: Array) -> Camera:
        turn = np.array([0.0, 0.0, x[4]])
        tilt = np.degrees(_combined(np.array([x[2], x[3], 0.0]), turn))
        place = (float(x[0]), float(x[1]), height)
        length = first_focal * np.exp(x[5]) if focal is None else first_focal
        return _camera(values | {"focal_px": float(length), "place_m": place, "tilt_deg": tuple(map(float, tilt))})

    def residual(x: Array) -> Array:
        try:
            seen, _ = camera(x).sight(pixels, depth)
        except InputError:
            return np.full(places.size, 1e3)
        return np.asarray((seen - places).ravel() / abs(factor))

    solution = least_squares(residual, start, x_scale=[height, height, 0.1, 0.1, 0.1, 0.1])
    return camera(solution.x), solution.fun.reshape(-1, 2)


def _combined(tilt: Array, turn: Array) -> Array:
    """Return the rotation vector of `turn` applied after `tilt`, both rotation vectors [rad]."""
    from scipy.spatial.transform import Rotation

    return np.asarray((Rotation.from_rotvec(turn) * Rotation.from_rotvec(tilt)).as_rotvec())


def _lens(film: Film, squares: tuple[int, int]) -> tuple[float, tuple[float, float], float, dict[str, Any]]:
    """Return focal length [px], center [px], k1 and a report of the fit, from a film of a checkerboard."""
    need("film", "cv2", by="calibration")
    import cv2

    grid = np.zeros((squares[0] * squares[1], 3), np.float32)
    grid[:, :2] = np.mgrid[: squares[0], : squares[1]].T.reshape(-1, 2)
    samples = film.sample()
    seen = []
    for sample in samples:
        found, points = cv2.findChessboardCornersSB(sample, squares)
        if found:
            seen.append(points.astype(np.float32))
        if len(seen) == MAX_BOARDS:
            break
    if len(seen) < MIN_BOARDS:
        rule = f"must show the board of {squares[0]} x {squares[1]} inner corners in {MIN_BOARDS} of its frames"
        fix = "film it whole, tilted in several ways, and give its inner corners by --squares"
        raise InputError(rule, file=film.file, value=f"seen in {len(seen)} of {len(samples)}", fix=fix)
    flags = cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_ASPECT_RATIO
    start = np.array([[film.width, 0, film.width / 2], [0, film.width, film.height / 2], [0, 0, 1]], float)
    rms, matrix, lens, _, _ = cv2.calibrateCamera(
        [grid] * len(seen), seen, (film.width, film.height), start, None, flags=flags | cv2.CALIB_USE_INTRINSIC_GUESS
    )
    report = {"boards": len(seen), "board_rms_px": float(rms)}
    return float(matrix[0, 0]), (float(matrix[0, 2]), float(matrix[1, 2])), float(np.ravel(lens)[0]), report
