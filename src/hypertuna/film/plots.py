"""Figure to check a tracked film: the frames that fit worst, the path, the joint angles and the fitted beat."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hypertuna.arrays import Array
from hypertuna.figures import COLORS, FAINT, INK, TIGHT, WIDTH, styled
from hypertuna.film.overlay import drawn
from hypertuna.film.run import FilmRun
from hypertuna.film.states import STATES

WORST = 4  # number of frames shown, those that fit worst


@styled
def plot_film(run: FilmRun, *, width: float = WIDTH) -> Figure:
    """Plot the frames whose edges fit worst, the head's path, and the joint angles; width [inch]."""
    figure = Figure(figsize=(width, 1.25 * width), layout="constrained")
    rows = figure.subplots(3, 1, height_ratios=(1.2, 0.8, 1.0))
    grid = rows[0].get_subplotspec().subgridspec(2, WORST // 2)
    rows[0].remove()
    worst = _worst(run.tracked.offset)
    frames = (next(iter(run.view.film.frames(number))) for number in worst)
    pictures = {k: drawn(run, k, frame) for k, frame in frames}
    for place, number in enumerate(worst):
        panel = figure.add_subplot(grid[place])
        panel.set_axis_off()
        if number in pictures:
            box, _ = run.view.box(run.body, np.append(run.tracked.unknowns[number], [run.tuning.size, 0.0, 0.0]))
            panel.imshow(pictures[number][box][..., ::-1])
        state = STATES[run.tracked.state[number]]
        panel.set_title(f"frame {number}: {run.tracked.offset[number]:.2f} px off, {state}", fontsize="small")
    own = np.concatenate(run.stretches)
    head, time = run.head[own], run.tracked.time[own]
    rows[1].plot(head[:, 0], head[:, 1], color=INK)
    rows[1].set_aspect("equal", adjustable="datalim")
    rows[1].set_xlabel("x of the head [m]")
    rows[1].set_ylabel("y [m]")
    for k, group in enumerate(run.body.groups):
        rows[2].plot(time, np.degrees(run.angle[own, k]), ".", markersize=2, color=COLORS[k % len(COLORS)], label=group)
        if run.beat is not None:
            label = "steady beat" if k + 1 == len(run.body.groups) else ""
            rows[2].plot(time, np.degrees(run.beat.angle(time)[:, k]), color=FAINT, linewidth=0.8, label=label)
    rows[2].set_xlabel("time [s]")
    rows[2].set_ylabel("joint angle [deg]")
    rows[2].legend(ncols=len(run.body.groups) + 1, loc="lower right", bbox_to_anchor=(1, 1), markerscale=3, **TIGHT)
    figure.suptitle(f"{run.name}: worst frames, path and joint angles")
    return figure


def _worst(offset: Array) -> list[int]:
    """Return the numbers of the frames whose edges are farthest off, in order of time; offset: (frames,) [px]."""
    measured = np.flatnonzero(np.isfinite(offset))
    return sorted(measured[np.argsort(-offset[measured])][:WORST].tolist())
