"""What is stored of finite elements, against a coarse mesh that is quick; validation/fe/ledger.py compares it all."""

import pytest

from hypertuna.fe.bend import fe_bend
from hypertuna.fe.model import FeOptions
from hypertuna.paper.chapters.finite_elements import read_elements

COARSE = 0.05  # by which the bend of a coarse mesh may differ from that of the stored one


@pytest.mark.fe
def test_a_coarse_mesh_bends_nearly_as_far_as_the_stored_one() -> None:
    stored = read_elements().solved["II"]
    k = list(stored.pressure).index(50e3)
    found = fe_bend(stored.robot, "II", stored.pressure[[k]], options=FeOptions(mesh="coarse"))
    assert found.status == "converged", found.status_text
    assert found.angle[-1] == pytest.approx(stored.angle[k], rel=COARSE)
    assert 1e6 * found.volume[-1] == pytest.approx(stored.column("volume_left_ml")[k], rel=COARSE)
