"""Fig. 12: how the identification converges, and checks of what the model predicts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hypertuna.identification.identify import Fit
from hypertuna.metrics import cost_of_transport
from hypertuna.paper.computed import OURS, PAPER, SPEEDS, Trial
from hypertuna.reports.html import WIDTH, Picture, Section
from hypertuna.swimming.swim import swim

__all__ = ["sections"]


def sections(fits: Mapping[str, Fit], trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show Fig. 12.

    Parameters
    ----------
    fits : mapping of str to Fit
        The nine coefficients of Table III from the eight published speeds, by model.
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    return [
        Section(
            "Checks of the model, Fig. 12",
            [_text(paper), _path(fits, paper), _speeds(fits, trials, paper), _start(trials), _costs(trials, paper)],
        )
    ]


def _text(paper: Mapping[str, Any]) -> str:
    """Say what of Fig. 12 can be compared."""
    bound = paper["values"]["speed/model-error-max"]["value"]
    return f"""Fig. 12 shows how the authors' identification converged (a), the speeds of its validation set (b), one
start from rest (c) and normalized cost of transport (d). **Its curves are pictures without numbers, and the
validation set is not published**, so only what the text says can be compared: that no speed is off by more than
{bound:g} %, and that normalized cost follows the trend of the measurement within 7 %. Shown here are the same
quantities for the eight published speeds and the two published costs."""


def _path(fits: Mapping[str, Fit], paper: Mapping[str, Any]) -> Picture:
    """Draw Fig. 12(a)."""
    from hypertuna.paper.figures import plot_paths

    frees = next(iter(fits.values())).free
    low, high = (np.array([getattr(one, side) for one in frees]) for side in ("lower", "upper"))
    places = {model: (fit.path - low) / (high - low) for model, fit in fits.items()}
    names = [one.name.rpartition(".")[2].replace("added_mass", "added mass") for one in frees]
    begin = "the paper's start values" if len(next(iter(fits.values())).costs) == 1 else "the best of several starts"
    rounds = " and ".join(f"{len(fit.path) - 1} with {model}" for model, fit in fits.items())
    return Picture(
        "fig12a",
        plot_paths(places, names, width=WIDTH),
        f"Fig. 12(a): the nine coefficients on their way from {begin} to the best fit of the eight "
        f"published speeds, in {rounds}; the authors' needed {paper['identification']['rounds']} rounds on their own "
        "data. Each between its bounds of Table III; most end on one.",
        "`hypertuna.identification.identify` with exact derivatives: SciPy's trust region method.",
    )


def _speeds(fits: Mapping[str, Fit], trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Picture:
    """Draw Fig. 12(b)."""
    from hypertuna.paper.figures import plot_against

    truth = [paper["values"][f"speed/{name}"]["value"] for name in SPEEDS]
    computed = {model: [trials[model].gaits[name].speed for name in SPEEDS] for model in (PAPER, OURS)}
    for model, fit in fits.items():
        computed[f"{model}, refitted"] = [swim(fit.robot, trials[model].gaits[name].gait).speed for name in SPEEDS]
    return Picture(
        "fig12b",
        plot_against(truth, computed, width=WIDTH),
        "Fig. 12(b): computed against published speeds of the eight gaits. In the gray band they agree within the "
        "5 % that the paper claims for its validation set; with ideal joints no coefficients bring them there.",
        "Settled beats with Table III unchanged, and with the nine coefficients refitted to these very speeds.",
    )


def _start(trials: Mapping[str, Trial]) -> Picture:
    """Draw Fig. 12(c)."""
    from hypertuna.paper.figures import plot_start

    start = trials[OURS].start
    angles = ",".join(f"{angle:g}" for angle in np.degrees(start.gait.amplitude).round(6))
    return Picture(
        "fig12c",
        plot_start({model: trials[model].start for model in (PAPER, OURS)}, width=WIDTH),
        f"Fig. 12(c): speed from rest at {start.gait.frequency:g} Hz, {np.degrees(start.gait.phase[-1]):.0f} deg and "
        "medium amplitude, at every instant (thin) and as the mean of each beat (bold). The paper's curve has no "
        "numbers to compare.",
        f"Made by `hypertuna swim --frequency {start.gait.frequency:g} --amplitude {angles} --phase 0,20 --from-rest "
        f"{start.duration:g}`.",
    )


def _costs(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Picture:
    """Draw what numbers allow of Fig. 12(d)."""
    from hypertuna.paper.figures import plot_normalized

    row = list(paper["tank"]["amplitude_deg"]).index("large")
    column = paper["tank"]["phase_deg"].index(paper["values"]["optimal-phase/fastest"]["value"])
    cost = {
        model: trials[model].tank.cost_of_transport.isel(amplitude=row, bias=0, phase=column).values
        for model in (PAPER, OURS)
    }
    best = paper["values"]["cost-of-transport/minimum"]["value"]
    robot, lake = trials[OURS].robot, paper["lake"]
    lake_cost = float(cost_of_transport(lake["energy_wh"] * 3600 / lake["distance_m"], robot.body.mass, 1.0))
    points = [
        (robot.gaits["unoptimised-max"].frequency, 1.0, "tank"),
        (robot.gaits["optimised-0.5"].frequency, lake_cost / best, "lake"),
    ]
    return Picture(
        "fig12d",
        plot_normalized(
            paper["tank"]["frequency_hz"],
            {model: values / values[-1] for model, values in cost.items()},
            points,
            width=WIDTH,
        ),
        "Fig. 12(d), as far as there are numbers: cost of transport over that of the fastest gait. Computed, it "
        "rises with frequency; the two electrical costs that the paper gives (stars) are nearly equal, and its text "
        "says that the measured cost falls.",
        f"Large amplitude and 40 deg; {best:g} J/(kg m) in the tank, {lake['energy_wh']:g} Wh for "
        f"{lake['distance_m']:g} m or {lake_cost:.1f} J/(kg m) in the lake.",
    )
