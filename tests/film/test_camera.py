"""The camera against rays that another program traces, and its calibration against cameras that are known."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from film.rendered import Eye, write_film
from film.small import camera
from hypertuna.cli.main import app
from hypertuna.errors import InputError
from hypertuna.film.calibrate import calibrate
from hypertuna.film.camera import Camera, read_camera, write_camera

EYE = Eye(size=(320, 240), focal=300.0, k1=-0.15, place=(0.1, -0.2, 1.5))


def grid(eye):
    return np.stack(np.meshgrid(np.arange(eye.size[0]), np.arange(eye.size[1])), axis=-1)


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.08, -0.05)])
def test_pixels_see_where_rays_end(tilt) -> None:
    eye = replace(EYE, tilt=tilt)
    a, b = tilt
    down = np.diag([1.0, -1.0, -1.0])
    turned = down @ Rotation.from_euler("XY", [a, b]).as_matrix() @ down
    own = camera(replace(eye, tilt=(0.0, 0.0)))
    own = own.model_copy(update={"tilt": tuple(Rotation.from_matrix(turned).as_rotvec())})
    place, lean = own.sight(grid(eye), 0.3)
    there, aside = eye.rays(0.3)
    np.testing.assert_allclose(place, there, atol=1e-9)
    np.testing.assert_allclose(lean, -aside, atol=1e-9)  # up, where rays go down
    np.testing.assert_allclose(own.pixels(place[::40, ::40], 0.3), grid(eye)[::40, ::40], atol=1e-5)


def test_a_camera_is_read_as_it_was_written(tmp_path) -> None:
    own = camera(EYE)
    write_camera(own, tmp_path / "camera.toml", "a camera")
    assert read_camera(tmp_path / "camera.toml") == own


@pytest.mark.parametrize(
    ("line", "sentence"),
    [("focal_px = 0", "focal_px"), ("tilt_deg = [90.0, 0.0, 0.0]", "tilt_deg"), ("zoom = 2", "zoom")],
)
def test_a_mistake_in_a_camera_is_named(tmp_path, line, sentence) -> None:
    write_camera(camera(EYE), tmp_path / "camera.toml", "a camera")
    key = line.partition(" =")[0]
    lines = (tmp_path / "camera.toml").read_text().splitlines()
    (tmp_path / "camera.toml").write_text("\n".join([*(one for one in lines if not one.startswith(key)), line]))
    with pytest.raises(InputError, match=sentence):
        read_camera(tmp_path / "camera.toml")


def corners(eye, path, depth=0.0):
    """Write points of the tank near the corners of the picture, where the eye sees them."""
    there, _ = eye.rays(depth)
    rows = [(u, v, *there[v, u]) for u in (20, 160, 300) for v in (15, 225)]
    path.write_text("u_px,v_px,x_m,y_m\n" + "".join(f"{u},{v},{x:.7f},{y:.7f}\n" for u, v, x, y in rows))
    return path


@pytest.mark.parametrize("depth", [0.0, 0.5])
def test_corners_give_place_tilt_and_focal_length(tmp_path, depth) -> None:
    eye = replace(EYE, tilt=(0.06, -0.04))
    file = corners(eye, tmp_path / "corners.csv", depth)
    found, about = calibrate(size=eye.size, corners=file, corner_depth=depth, height=1.5, lens_k1=eye.k1)
    there, _ = eye.rays(0.1)
    place, _ = found.sight(grid(eye), 0.1)
    assert about["corner_rms_px"] < 0.01
    assert np.cos(found.off_vertical) == pytest.approx(np.cos(0.06) * np.cos(0.04), abs=2e-5)
    assert np.abs(place - there).max() < 2e-4  # m, of a picture 1.6 m wide
    assert found.focal == pytest.approx(eye.focal, rel=1e-3)


def test_a_board_gives_the_lens(tmp_path) -> None:
    width, height, focal, k1 = 640, 480, 560.0, -0.12
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    square, draw = 40, np.random.default_rng(1)
    board = 255 * ((np.indices((7, 10)).sum(axis=0) % 2) == 0).astype(np.uint8).repeat(square, 0).repeat(square, 1)
    board = np.pad(board, square, constant_values=255)
    u, v = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    flat = cv2.undistortPoints(np.stack([u, v], -1).reshape(-1, 1, 2), matrix, np.array([k1, 0, 0, 0]))[:, 0]

    def pictures():
        for _ in range(30):
            turn = Rotation.from_rotvec(draw.uniform(-0.5, 0.5, 3)).as_matrix()
            at = np.array([*draw.uniform(-60, 60, 2), draw.uniform(560, 700)])  # of the board's middle, in its pixels
            plane = np.column_stack([turn[:, :2], at - turn[:, :2] @ (np.array(board.shape[::-1]) / 2)])
            seen = np.column_stack([flat, np.ones(len(flat))]) @ np.linalg.inv(plane).T
            place = (seen[:, :2] / seen[:, 2:]).reshape(height, width, 2).astype(np.float32)
            yield cv2.remap(board, place[..., 0], place[..., 1], cv2.INTER_AREA, borderValue=120)

    write_film(tmp_path / "board.mp4", pictures(), rate=30)
    found, about = calibrate(board=tmp_path / "board.mp4", height=1.5)
    assert about["boards"] >= 10
    assert about["board_rms_px"] < 0.5
    assert found.focal == pytest.approx(focal, rel=0.01)
    assert found.lens_k1 == pytest.approx(k1, abs=0.02)


def test_what_a_camera_lacks_is_told(tmp_path) -> None:
    with pytest.raises(InputError, match="--size must be given"):
        calibrate(height=1.5)
    with pytest.raises(InputError, match="--focal must be given"):
        calibrate(size=(640, 480), height=1.5)
    (tmp_path / "three.csv").write_text("u_px,v_px,x_m,y_m\n1,1,0,0\n9,1,1,0\n9,9,1,1\n")
    with pytest.raises(InputError, match="4 points"):
        calibrate(size=(640, 480), height=1.5, corners=tmp_path / "three.csv")
    (tmp_path / "line.csv").write_text("u_px,v_px,x_m,y_m\n" + "".join(f"{k},{k},{k},{k}\n" for k in range(5)))
    with pytest.raises(InputError, match="one line"):
        calibrate(size=(640, 480), height=1.5, corners=tmp_path / "line.csv")
    Camera.model_validate(camera(EYE).model_dump(by_alias=True))


def test_a_mirrored_film_is_told_by_the_corners(tmp_path) -> None:
    file = corners(EYE, tmp_path / "corners.csv", 0.0)
    head, *rows = file.read_text().splitlines()
    turned = [",".join([str(EYE.size[0] - 1 - int(u)), *rest]) for u, *rest in (row.split(",") for row in rows)]
    file.write_text("\n".join([head, *turned]) + "\n")
    with pytest.raises(InputError, match="mirrored"):
        calibrate(size=EYE.size, corners=file, height=1.5)


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.06, -0.04)])
def test_command(tmp_path, tilt) -> None:
    """A turn about the vertical is no tilt."""
    file, output = corners(replace(EYE, tilt=tilt), tmp_path / "corners.csv", 0.0), tmp_path / "camera.toml"
    head, *rows = file.read_text().splitlines()
    turned = ((u, v, -float(y), x) for u, v, x, y in (row.split(",") for row in rows))
    file.write_text("\n".join([head, *(",".join(map(str, row)) for row in turned)]))
    own = ["trials", "camera", "--size", "320,240", "--corners", str(file), "--height", "1.5", "--lens-k1", "-0.15"]
    result = CliRunner().invoke(app, [*own, "-o", str(output)])
    assert result.exit_code == 0, result.output
    assert read_camera(output).focal == pytest.approx(EYE.focal, rel=0.01)
    off = float(re.search(r"looks (\S+) deg off straight down", result.output)[1])
    assert off == pytest.approx(np.degrees(np.hypot(*tilt)), abs=0.06)
    own = ["trials", "camera", "--size", "320,240", "--focal", "300", "--height", "1.5", "-o", str(output)]
    assert "is taken to look straight down" in CliRunner().invoke(app, own).output


def change(rows, how):
    """Points of the tank after a mistake."""
    u, v, x, y = np.array(rows).T
    return {
        "next one": np.column_stack([u, v, np.roll(x, 1), np.roll(y, 1)]),
        "mm": np.column_stack([u, v, 1000 * x, 1000 * y]),
        "parts": np.column_stack([u / 320, v / 240, x, y]),
        "larger picture": np.column_stack([2 * u, 2 * v, x, y]),
        "twice": np.array([rows[0], *rows[:-1]]),
        "exchanged": np.column_stack([u, v, x[[1, 0, *range(2, len(x))]], y[[1, 0, *range(2, len(y))]]]),
    }[how]


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ("next one", "px off in the mean: is each pixel beside its own point, in m"),
        ("mm", "the focal length must be from 0.2 to 10 times the picture's width of 320 px, but is 0.28"),
        ("parts", "u_px and v_px must be pixels, but is close together: parts of the picture's width and height"),
        ("larger picture", "the points must lie in the picture of 320 x 240 px, but is [600.0, 30.0]: give the size"),
        ("twice", "the points must be distinct, but is given twice"),
        ("exchanged", "is each pixel beside its own point"),
    ],
)
def test_corners_that_no_camera_sees_are_refused(tmp_path, how, sentence) -> None:
    """Four corners in order around the picture."""
    there, _ = EYE.rays(0.0)
    rows = [(u, v, *there[v, u]) for u, v in ((20, 15), (300, 15), (300, 225), (20, 225))]
    lines = [",".join(f"{value:.6f}" for value in row) for row in change(rows, how)]
    (tmp_path / "c.csv").write_text("\n".join(["u_px,v_px,x_m,y_m", *lines]))
    with pytest.raises(InputError, match=re.escape(sentence)):
        calibrate(size=EYE.size, corners=tmp_path / "c.csv", height=1.5, lens_k1=EYE.k1)


def test_a_height_in_another_unit_or_a_focal_length_in_mm_is_refused(tmp_path) -> None:
    file = corners(EYE, tmp_path / "corners.csv")
    with pytest.raises(InputError, match="must be from 0.2 to 10 times the picture's width of 320 px"):
        calibrate(size=EYE.size, corners=file, height=150.0)
    with pytest.raises(
        InputError, match="--focal must be from 0.2 to 10 times the picture's width of 320 px, but is 4"
    ):
        calibrate(size=EYE.size, height=1.5, focal=4.0)


def test_a_corner_that_is_a_little_off_is_told(tmp_path) -> None:
    file = corners(EYE, tmp_path / "corners.csv")
    head, first, *rest = file.read_text().splitlines()
    u, v, x, y = first.split(",")
    file.write_text("\n".join([head, f"{u},{v},{float(x) + 0.02:.6f},{y}", *rest]))
    _, about = calibrate(size=EYE.size, corners=file, height=1.5, lens_k1=EYE.k1)
    assert "The points are 0.9 px off in the mean: is each pixel" in about["warnings"][0]
