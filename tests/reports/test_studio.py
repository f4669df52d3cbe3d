"""The studio's page in a notebook and as a file."""

import base64
import gzip
import hashlib
import html
import json
import re
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.identification.image import sampled_image
from hypertuna.mission.log import write_log
from hypertuna.reports import studio as module
from voyage import voyage


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
        "Studio of hypertuna at 2.13 Hz, amplitude 15.62, 24.31 deg, phase 0, 38.56 deg",
        "A notebook shows it; save(path) writes the page.",
    ]
    assert repr(ht.studio("rexeel")).startswith("Studio of rexeel\n")


def test_save_writes_the_page(tmp_path: Path) -> None:
    shown = ht.studio(ht.load("rexeel"), ht.Gait.from_degrees(frequency=1, amplitude=(9,) * 5, phase=(0,) * 5))
    assert shown.save(tmp_path / "fish.html").read_text(encoding="utf-8") == shown.html


def test_a_log_is_played_with_the_robot_that_it_is_of(tmp_path: Path) -> None:
    log = write_log(voyage(20), tmp_path / "box.mcap")
    shown = ht.studio(log)
    assert shown.robot.name == "hypertuna"
    assert repr(shown).splitlines()[0] == "Studio of hypertuna with the log box.mcap"
    (content,) = re.findall(r'id="log" data-name="box.mcap">([^<]*)<', shown.html)
    assert base64.b64decode(content) == log.read_bytes()
    own = tmp_path / "mine.toml"
    own.write_text((Path(__file__).parents[2] / "robots/rexeel.toml").read_text().replace('"rexeel"', '"mine"', 1))
    facts = {"robot_file": str(own)}
    write_log(replace(voyage(20), robot="mine", facts=facts), log)
    for of in (ht.studio, lambda file: ht.studio("rexeel", log=file)):
        with pytest.raises(ht.InputError, match=r"box.mcap (is|must be) of .*'mine'"):  # and no file that it names
            of(log)
    assert ht.studio(own, log=log).robot.name == "mine"
    log.write_bytes(b"no log")
    with pytest.raises(ht.InputError, match=r"box.mcap must be an MCAP file"):
        ht.studio(log)


def test_arguments_are_checked() -> None:
    with pytest.raises(ht.InputError, match="height must be from 200 to 4000, but is 20"):
        ht.studio("rexeel", height=20)
    with pytest.raises(ht.InputError, match="must be a gait of the robot"):
        ht.studio("rexeel", "turning")
    with pytest.raises(ht.InputError, match="must be 5 long"):
        ht.studio("rexeel", ht.Gait(1.0, (0.1, 0.1), (0.0, 0.0)))


def test_no_name_ends_the_script() -> None:
    fish = ht.load("hypertuna").model_copy(update={"name": "</script><b>"})
    data = re.findall(r'id="robots">(.*?)</script>', module.studio_page(fish), re.DOTALL)
    assert json.loads(data[0])["robots"][0]["name"] == "</script><b>"


def test_a_page_that_is_missing_or_foreign_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "shipped", lambda _: tmp_path)
    with pytest.raises(ht.InputError, match=r"data/studio/studio.html is missing: install hypertuna anew"):
        module.studio_page(ht.load("rexeel"))
    (tmp_path / "studio.html").write_text("<title>x</title>")
    with pytest.raises(ht.InputError, match=r"has no place for robots: build it anew: make studio"):
        module.studio_page(ht.load("rexeel"))


# --- the page that is kept


STORED = Path(__file__).parents[2] / "data/studio"
MADE = json.loads((STORED / "made.json").read_text(encoding="utf-8"))
ANEW = "run `make studio` and commit data/studio"


def robots() -> dict[str, bytes]:
    """Return the images in the page, by the names of their robots."""
    (content,) = re.findall(r'id="robots">(.*?)</script>', module.shipped_page(), re.DOTALL)
    found: dict[str, bytes] = {
        one["name"]: gzip.decompress(base64.b64decode(one["image"])) for one in json.loads(content)["robots"]
    }
    return found


def columns_and_text(image: bytes) -> tuple[np.ndarray, dict[str, Any]]:
    """Return all numbers of an image, and its text."""
    count, names, size, numbers = struct.unpack("<4I", image[16:32])
    start = 32 + 12 * count + names
    return np.frombuffer(image[-8 * numbers :]), json.loads(image[start : start + size])


def test_the_page_is_of_the_present_sources() -> None:
    sources = Path(__file__).parents[2] / "studio"
    present = [file for folder in (sources, sources / "sea") for file in folder.iterdir()]
    names = {str(file.relative_to(sources)) for file in present if file.suffix in (".ts", ".css")}
    assert names <= MADE["sources"]["page"].keys()
    for name, digest in MADE["sources"]["page"].items():
        assert hashlib.sha256((sources / name).read_bytes()).hexdigest() == digest, f"{name}: {ANEW}"


def test_the_robots_of_the_page_are_the_present_ones() -> None:
    """To rounding: the last bits of a controller's numbers are those of the machine that wrote them."""
    found = robots()
    assert next(iter(found)) == "hypertuna"
    assert sorted(found) == sorted(ht.robots())
    for name, image in found.items():
        numbers, text = columns_and_text(image)
        present, wanted = columns_and_text(sampled_image(ht.load(name)))
        assert text == wanted, f"{name}: {ANEW}"
        np.testing.assert_allclose(numbers, present, rtol=1e-9, atol=1e-12, err_msg=f"{name}: {ANEW}")
        assert hashlib.sha256(image).hexdigest() == MADE["sources"]["robots"][name]


def test_the_core_of_the_page_is_the_one_it_names() -> None:
    (content,) = re.findall(r'id="core">(.*?)</script>', module.shipped_page(), re.DOTALL)
    core = gzip.decompress(base64.b64decode(content))
    assert hashlib.sha256(core).hexdigest() == MADE["sources"]["core"]
    assert core.startswith(b"\0asm")


def test_the_page_is_small() -> None:
    """A third is code of hinges. The Sea view with three.js comes on top: it is unpacked when it is first opened."""
    first, block, rest = re.split(r'(?<=id="sea-block">)([^<]*)', module.shipped_page(), maxsplit=1)
    assert len(gzip.compress((first + rest).encode())) < 580_000
    assert len(gzip.decompress(base64.b64decode(block))) < 800_000
    assert len(block) < 280_000
