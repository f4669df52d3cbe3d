"""The page on a fit: what it says first, and which laws it compares."""

from types import SimpleNamespace
from typing import Any

import pytest

from hypertuna.reports import fit as page

SPEED = "speed_relative"


def fitted(*, validation: float | None) -> Any:
    """Return what the page's head needs of a fit: its speed 2 % off in the fitted runs, `validation` in the others."""
    unseen = None if validation is None else SimpleNamespace(rms={SPEED: validation})
    return SimpleNamespace(
        train=SimpleNamespace(rms={SPEED: 0.02}),
        validation=unseen,
        uncertainty=SimpleNamespace(directions=[SimpleNamespace(constrained=known) for known in (True, True, False)]),
        free=("drag", "added_mass", "shed"),
        robot=SimpleNamespace(name="Fish", fit=SimpleNamespace(trials="trials.toml")),
    )


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return what the page's head and its sections are given."""
    seen: dict[str, Any] = {}
    monkeypatch.setattr(page, "fit_sections", lambda fit, **given: seen.update(given) or [])
    monkeypatch.setattr(page, "write_page", lambda title, sections, path, **head: seen.update(head))
    return seen


@pytest.mark.parametrize(
    ("validation", "error", "runs"),
    [(0.05, "5 %", "runs that were not fitted"), (None, "2 %", "the fitted runs")],
)
def test_the_error_is_that_of_unseen_runs_where_there_are_any(
    written: dict[str, Any], validation: float | None, error: str, runs: str
) -> None:
    page.write_fit({"strip": fitted(validation=validation)}, "strip", "fit.html")
    told, known = written["facts"]
    assert (told.number, told.text) == (error, f"rms error of speed in {runs}")
    assert known.number == "2 of 3"
    assert written["lede"] == "3 coefficients of Fish, strip water law, fitted to trials.toml."


def test_laws_are_compared_where_there_are_several(written: dict[str, Any]) -> None:
    fits = {"strip": fitted(validation=None), "lumped": fitted(validation=None)}
    page.write_fit(fits, "strip", "fit.html")
    assert written["laws"] == fits
    page.write_fit({"strip": fits["strip"]}, "strip", "fit.html")
    assert written["laws"] == {}
