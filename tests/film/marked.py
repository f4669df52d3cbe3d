"""Films of a fish with colored dots or tags on its back, drawn by tracing rays to the plane of its axis."""

import av
import cv2
import numpy as np

from film.rendered import FINE, Eye, Scene, frames
from film.small import DEPTH, fish


def write_colors(path, pictures, rate=60, crf=18, codec="libx264"):
    """Write frames of blue, green, red."""
    with av.open(str(path), "w") as out:
        stream = None
        for picture in pictures:
            if stream is None:
                stream = out.add_stream(codec, rate=rate, options={"crf": str(crf), "preset": "veryfast"})
                (stream.height, stream.width), stream.pix_fmt = picture.shape[:2], "yuv420p"
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        out.mux(stream.encode(None))


def spot(drawn, pose, angle, from_nose, across=0.0):
    """Place (2,) [m] of a spot on a bent body, and the direction of its link [rad]; across: to starboard."""
    heading, at, begin = pose[2] + drawn.share @ angle, np.array(pose[:2]), 0.0
    for k, (long, turn) in enumerate(zip(drawn.length, heading, strict=True)):
        e = np.array([np.cos(turn), np.sin(turn)])
        if from_nose <= begin + long or k == len(drawn.length) - 1:
            return at + (from_nose - begin) * e + across * np.array([-e[1], e[0]]), turn
        at, begin = at + long * e, begin + long
    raise AssertionError


def _near(ray, place, room):
    """Rows and columns of the pixels that may see a place within some room [m]."""
    middle = ray.shape[0] // 2, ray.shape[1] // 2
    columns = np.flatnonzero(np.abs(ray[middle[0], :, 0] - place[0]) < 1.2 * room + 0.01)
    rows = np.flatnonzero(np.abs(ray[:, middle[1], 1] - place[1]) < 1.2 * room + 0.01)
    return tuple(slice(k[0], k[-1] + 1) if len(k) else slice(0, 0) for k in (rows, columns))


def dotted(
    motion, spots, eye, color=(40, 40, 220), radius=0.006, count=60, rate=60, hidden=lambda k, d: False, **scene
):
    """Yield frames of a fish with dots of a radius [m] at distances from the nose [m]; hidden: by frame and dot."""
    drawn, here = fish(), [eye.rays(DEPTH, shift)[0] for shift in FINE]
    pixel = np.abs(np.diff(here[0][:2, 0, 1]))[0]
    times = np.arange(count) / rate
    setting = Scene(eye, drawn, depth=DEPTH, rate=rate, **scene)
    for k, gray in enumerate(frames(setting, motion, times)):
        cover = np.zeros(gray.shape)
        for at in (at for d, at in enumerate(spots) if not hidden(k, d)):
            place, _ = spot(drawn, *motion(times[k]), at)
            box = _near(here[0], place, radius)
            apart = [np.linalg.norm(ray[box] - place, axis=-1) for ray in here]
            each = np.mean([np.clip(0.5 + (radius - one) / (pixel / 2), 0, 1) for one in apart], axis=0)
            cover[box] = np.maximum(cover[box], each)
        picture = cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR).astype(float)
        yield np.rint(picture + (np.array(color) - picture) * cover[..., np.newaxis]).astype(np.uint8)


def tagged(motion, spots, eye, ids, cell=0.0025, count=40, rate=60, **scene):
    """Yield frames of a fish with tags of 8 x 8 cells [m], white rim included, at distances from the nose."""
    drawn, here = fish(), [eye.rays(DEPTH, shift)[0] for shift in FINE]
    book = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    faces = [np.pad(cv2.aruco.generateImageMarker(book, tag, 6), 1, constant_values=255) for tag in ids]
    times = np.arange(count) / rate
    setting = Scene(eye, drawn, depth=DEPTH, rate=rate, **scene)
    for k, gray in enumerate(frames(setting, motion, times)):
        picture = gray.astype(float)
        for at, face in zip(spots, faces, strict=True):
            place, turn = spot(drawn, *motion(times[k]), at)
            e, n = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
            box = _near(here[0], place, 6 * cell)
            shown = np.zeros(picture[box].shape)
            for ray in here:
                column, row = ((ray[box] - place) @ axis / cell + 4 for axis in (e, -n))  # rows go to starboard
                inside = (column > 0) & (column < 8) & (row > 0) & (row < 8)
                face_value = 40 + 0.7 * face[np.clip(row, 0, 7.9).astype(int), np.clip(column, 0, 7.9).astype(int)]
                shown += np.where(inside, face_value, picture[box]) / len(here)
            picture[box] = shown
        yield cv2.cvtColor(np.rint(picture).astype(np.uint8), cv2.COLOR_GRAY2BGR)


WIDE = Eye(size=(880, 300), focal=2400.0, place=(0.0, 0.0, 1.6))  # a fish of 430 px
SLOW = Eye(size=(640, 240), focal=1000.0, k1=-0.1, place=(0.02, 0.0, 1.6))  # a fish of 180 px
