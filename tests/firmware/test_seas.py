"""Random seas: the verdict can fail, a sea follows from its seed, and some seas are flown."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flights import WildLoop, fly
from sampled_sea import FAULTS, GROUPS, KINDS, kinds_of, sampled
from verdict import Truth, judge

import hypertuna as ht
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware
from hypertuna.mission.file import parse_mission

RUN = Path(__file__).parents[2] / "validation" / "seas" / "run.py"


@pytest.fixture(scope="module")
def robot() -> ht.Robot:
    try:
        find_firmware("hypertuna", "pc")
    except InputError as error:
        pytest.skip(str(error))
    return ht.load("hypertuna")


def good(seed: int = 0) -> Truth:
    """A flight from start to home at the surface, by the book."""
    sea = sampled(seed)
    mission = parse_mission(sea.document).mission
    time = np.arange(0, 300.0)
    legs = np.linspace(mission.start, mission.course[-1], len(time))
    position = np.column_stack([legs, np.full(len(time), -0.1)])
    active = (time > 5) & (time < 290)
    return Truth(mission, time, position, np.full(len(time), 2.0), active, position, True, frozenset())


def test_a_sea_follows_from_its_seed() -> None:
    assert sampled(5) == sampled(5)
    assert sampled(5).document != sampled(5 + len(KINDS)).document
    assert [sampled(seed).kind for seed in range(len(KINDS))] == list(FAULTS)
    assert {sampled(seed).too_fast for seed in range(100)} == {False, True}
    for seed in range(100):
        parse_mission(sampled(seed).document)  # raises where it is no mission


def test_each_rule_of_the_verdict_can_break() -> None:
    sea, truth = sampled(0), good()
    assert judge(truth, sea).broken == ()
    assert judge(truth, sea).ending == "home"
    # (what differs, the rule)
    deep = truth.position - np.array([0, 0, 2.0])
    assert judge(replace(truth, position=deep), sea).broken == ("not up", "does not tell why")
    limit = truth.mission.depth_max
    dive = np.where((truth.time == 100)[:, None] & [False, False, True], -limit - 0.31, truth.position)
    assert judge(replace(truth, position=dive), sea).broken == ("too deep",)
    away = truth.position + np.array([30.0, 0, 0])
    unfenced = replace(truth, position=away, mission=replace(truth.mission, fence=()))
    assert judge(unfenced, sea).broken == ("done elsewhere", "does not tell why")
    assert judge(replace(unfenced, done=False), sea).broken == ("does not tell why",)
    assert judge(replace(unfenced, done=False, told=frozenset({"low_battery"})), sea).broken == ()
    square = ((-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3))
    fenced = replace(truth, mission=replace(truth.mission, fence=square))
    out = np.where((truth.time == 100)[:, None] & [True, False, False], 1007.0, truth.position)
    assert judge(replace(fenced, position=out), sea).broken == ("outside the fence",)
    assert judge(replace(fenced, position=out, sigma=np.full(len(truth.time), 2.5)), sea).broken == ()
    leak = sampled(KINDS.index("hull:leak"))
    leaking = replace(truth, mission=parse_mission(leak.document).mission)
    assert "does not tell why" in judge(leaking, leak).broken
    assert "does not tell why" not in judge(replace(leaking, told=frozenset({"leak"})), leak).broken
    never = replace(truth, active=np.zeros(len(truth.time), bool), done=False)
    assert judge(never, sea).broken == ("does not tell why", "refused without a reason")


def test_a_compass_is_off_by_what_its_sea_says() -> None:
    """The error of the told declination, or what iron turns the level field by at most, by all headings."""
    headings = np.linspace(0, 2 * np.pi, 3601)
    for seed in range(40):
        plain, turned, iron = (sampled(seed, kind) for kind in ("none", "compass turned", "compass iron"))
        told = [sea.document["origin"]["declination_deg"] for sea in (plain, turned)]
        assert abs((told[1] - told[0] + 180) % 360 - 180) == pytest.approx(np.degrees(turned.off), abs=0.02)
        assert turned.iron == (0, 0)
        flat = np.cos(np.radians(iron.document["weather"]["dip_deg"]))
        read = flat * np.exp(-1j * headings) + complex(*iron.iron)
        worst = np.abs(np.angle(read * np.exp(1j * headings))).max()
        assert worst == pytest.approx(iron.off, abs=0.01) if iron.off < 1.5 else worst > 1.5
        assert all(("compass" in sea.words) == (sea.off >= np.pi / 6) for sea in (turned, iron))


def test_claims_of_place_are_counted() -> None:
    """Of 284 seconds in which it is guided, 71 are 5 m off toward east, with a told deviation of 2 m."""
    truth, sea = good(), sampled(0)
    off = np.where((truth.time > 5) & (truth.time <= 76), 5.0, 0.0)
    verdict = judge(replace(truth, place=truth.place + np.column_stack([off, 0 * off, 0 * off])), sea)
    assert (verdict.within_two, verdict.within_three) == (1 - 71 / 284 / 2, 1)


def test_a_robot_that_ignores_its_pilot_fails(robot: ht.Robot) -> None:
    sea = replace(sampled(0), kind="none")
    verdict = judge(fly(sea, robot, loop=WildLoop), sea)
    assert verdict.broken
    assert verdict.broken != ("does not tell why",)


@pytest.mark.parametrize("kind", ["hull:leak", "board:watchdog", "link:lost"])
def test_a_sea_is_survived(robot: ht.Robot, kind: str) -> None:
    sea = sampled(KINDS.index(kind))
    assert judge(fly(sea, robot), sea).broken == ()


def test_a_robot_that_circles_on_its_line_says_so(robot: ht.Robot) -> None:
    assert "no_progress" in fly(sampled(0, "body:tethered"), robot).told


def test_seas_resume_after_a_kill(robot: ht.Robot, tmp_path: Path) -> None:
    """The journal of an interrupted run has the seas that ended, and the same command takes them from there."""
    command = [sys.executable, RUN, "--seeds", "16:18", "--journal", tmp_path / "journal", "-o"]
    first = subprocess.run([*command, tmp_path / "a.csv"], capture_output=True, text=True)
    assert "sea 17" in first.stderr, first.stderr
    lines = (tmp_path / "journal").read_bytes().splitlines(keepends=True)
    (tmp_path / "journal").write_bytes(b"".join(lines[:2]) + lines[2][:40])  # killed while it wrote sea 17
    again = subprocess.run([*command, tmp_path / "b.csv"], capture_output=True, text=True)
    assert again.returncode == first.returncode
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_a_run_has_as_many_seas_of_a_group_as_it_asks_for() -> None:
    kinds = kinds_of(range(300), {"entangled": 50})
    assert sum(kind in GROUPS["entangled"] for kind in kinds) >= 50
    assert set(kinds) == set(KINDS)
    assert kinds_of(range(len(KINDS)), {}) == list(KINDS)
    with pytest.raises(InputError, match="must fit into the seeds"):
        kinds_of(range(3), {"entangled": 4})
