"""The studio's page in a notebook and as a file."""

import html
import json
import re
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.reports import studio as module


def test_a_notebook_shows_the_page_in_a_frame() -> None:
    shown = ht.studio("hypertuna", "turning", height=500)
    frame = shown._repr_html_()
    found = re.fullmatch(
        r'<iframe title="Studio of hypertuna" style="[^"]*height: 500px[^"]*" srcdoc="([^"]*)"></iframe>', frame
    )
    assert found
    assert html.unescape(found[1]) == shown.html
    assert shown.html.count('id="robots"') == 1


def test_the_text_is_two_lines() -> None:
    assert repr(ht.studio("hypertuna", "optimised-0.3")).splitlines() == [
        "Studio of hypertuna at 2.13 Hz, amplitude 15.6, 24.3 deg, phase 0, 38.6 deg",
        "A notebook shows it; save(path) writes the page.",
    ]
    assert repr(ht.studio("rexeel")).startswith("Studio of rexeel\n")


def test_save_writes_the_page(tmp_path: Path) -> None:
    shown = ht.studio(ht.load("rexeel"), ht.Gait.from_degrees(frequency=1, amplitude=(9,) * 5, phase=(0,) * 5))
    assert shown.save(tmp_path / "fish.html").read_text(encoding="utf-8") == shown.html


def test_arguments_are_checked() -> None:
    with pytest.raises(ht.InputError, match="height must be from 200 to 4000, but is 20"):
        ht.studio("rexeel", height=20)
    with pytest.raises(ht.InputError, match="must be a gait of the robot"):
        ht.studio("rexeel", "turning")
    with pytest.raises(ht.InputError, match="must be 5 long"):
        ht.studio("rexeel", ht.Gait(1.0, (0.1, 0.1), (0.0, 0.0)))


def test_no_name_ends_the_script() -> None:
    fish = ht.load("rexeel").model_copy(update={"name": "</script><b>"})
    data = re.findall(r'id="robots">(.*?)</script>', module.studio_page(fish), re.DOTALL)
    assert json.loads(data[0])["robots"][0]["name"] == "</script><b>"


def test_a_page_that_is_missing_or_foreign_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "shipped", lambda _: tmp_path)
    with pytest.raises(ht.InputError, match=r"data/studio/studio.html is missing: install hypertuna anew"):
        module.studio_page(ht.load("rexeel"))
    (tmp_path / "studio.html").write_text("<title>x</title>")
    with pytest.raises(ht.InputError, match=r"has no place for robots: build it anew: make studio"):
        module.studio_page(ht.load("rexeel"))
