"""A surface for pictures is read as it was written, and nothing that it says of itself is believed."""

from pathlib import Path

import numpy as np
import pytest

from hypertuna.errors import InputError
from hypertuna.fe.fields import DISPLACEMENT, FACE, STRAIN, STRESS, read_surface
from mutations.surfaces import surface


def test_a_whole_surface_is_read(tmp_path: Path) -> None:
    path = tmp_path / "surface-000.vtu"
    path.write_bytes(surface())
    points, cells, types, fields = read_surface(path)
    assert points.shape == (66, 3)
    assert cells.tolist()[:14] == [4, 0, 1, 2, 3, 4, 4, 5, 6, 7, 3, 8, 9, 10]
    assert types.tolist() == [9, 9, 5] * 6
    assert list(fields) == [DISPLACEMENT, FACE, STRESS, STRAIN]
    np.testing.assert_array_equal(fields[DISPLACEMENT], 0.1 * points)
    np.testing.assert_array_equal(fields[STRAIN], points[:, 1])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        pytest.param((66 * 24).to_bytes(4, "little"), b"\xff\xff\xff\xff", id="a length of 4 GB"),
        pytest.param(
            np.array([3, 4, 5], "<i4").tobytes(),
            np.array([3, 4, 10**8], "<i4").tobytes(),
            id="a corner that is not there",
        ),
        pytest.param(
            np.array([3, 4, 5], "<i4").tobytes(), np.array([3, 4, -1], "<i4").tobytes(), id="a corner before the first"
        ),
        pytest.param(b"\5\t\t", b"\5\7\t", id="a face of other corners"),
        pytest.param(b'offset="1588"', b'offset="999999999"', id="an array behind the end"),
        pytest.param(b"von Mises", b"von Moses", id="a field that is missing"),
        pytest.param(b'encoding="raw"', b'encoding="base64"', id="another encoding"),
        pytest.param(
            np.array([4, 8, 11], "<i4").tobytes(),
            np.array([4, 8, 2**31 - 1], "<i4").tobytes(),
            id="an end behind the last",
        ),
    ],
)
def test_what_a_surface_says_of_itself_is_not_believed(old: bytes, new: bytes, tmp_path: Path) -> None:
    content, path = surface(), tmp_path / "surface-000.vtu"
    assert old in content
    path.write_bytes(content.replace(old, new, 1))
    with pytest.raises(InputError, match=r"surface-000\.vtu must be a whole surface: remove the folder and run"):
        read_surface(path)
