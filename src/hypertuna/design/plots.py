"""Figure of a design: intervals of targets and coefficients after each run."""

import numpy as np
from matplotlib.figure import Figure

from hypertuna.design.criterion import CHECK
from hypertuna.design.tank import NextRuns
from hypertuna.display import plots
from hypertuna.figures import FAINT, INK, POINTS, TIGHT, WIDTH, line_style, styled


@plots.of(NextRuns)
@styled
def plot_design(result: NextRuns, *, width: float = WIDTH) -> Figure:
    """Plot the half width of the target gaits' interval and the coefficients' standard deviations after each run."""
    figure = Figure(figsize=(width, 5.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    runs = np.arange(1, len(result.steps) + 1)
    widths = 100 * np.array([step.half_width for step in result.steps])
    above.axhline(100 * result.width, color=FAINT, lw=1, ls="--", label="enough")
    above.plot(runs, widths, marker="o", **line_style(0, 1), **POINTS, label="half width")
    checks = runs[CHECK - 1 :: CHECK]
    above.plot(checks, widths[CHECK - 1 :: CHECK], "s", color=INK, mfc="none", ms=7, mew=1.1, label="after a check")
    above.set(ylabel=f"{result.subject} of target gaits\n± [%]", title="Intervals after each run")
    above.set_ylim(bottom=0)
    above.legend(**TIGHT)
    sds = np.array([result.unknowns.sd, *(step.sd for step in result.steps)])
    for k, name in enumerate(result.unknowns.names):
        below.plot(np.arange(len(sds)), sds[:, k], **line_style(k), label=name.rpartition(".")[2])
    below.set(xlabel="runs", ylabel="standard deviation\nof the logarithm")
    below.set_yscale("log")
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower left", ncols=2 if width < 6 else 3, **TIGHT)
    return figure
