"""Pictures of cards, as SVG elements in the colors of the page's theme: curves, dots, bars and tracks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import chain

from hypertuna.display import number, safe

LOOP = 10.0  # s: longest duration of a track's animation
MIN_LABELED = 120  # px: width of a curve below which its ends share a label
BARS = 10  # largest number of bars in a picture
BODY = "M11 0Q5-5-2-4L-11 0-2 4Q5 5 11 0z"  # SVG path of the body in a track's animation, heading right


def captioned(svg: str, text: str) -> str:
    """Return a picture with a caption below it."""
    return f'{svg}<p class="ht-caption">{safe(text)}</p>'


def track_svg(x: Iterable[float], y: Iterable[float], seconds: float, label: str) -> str:
    """Draw a track from above and a body that moves along it; points are at equal times, `seconds` in all."""
    loop = min(LOOP, seconds)
    pace = "in real time" if loop == seconds else f"sped up {seconds / loop:.3g} times"
    return captioned(curve_svg(x, y, label, equal=True, loop=loop), f"The whole track from above, {pace}.")


def curve_svg(
    x: Iterable[float],
    y: Iterable[float],
    label: str,
    *,
    equal: bool = False,
    dots: bool = False,
    loop: float = 0.0,
    dashed: Sequence[Sequence[tuple[float, float]]] = (),
) -> str:
    """Draw a curve or dots as an SVG element, labeled with the extremes of the values.

    equal: use one scale for x and y. loop: period [s] of a body that moves along the curve. dashed: lines of points,
    drawn below the curve.
    """
    points = [(a, b) for a, b in zip(x, y, strict=True) if math.isfinite(a) and math.isfinite(b)]
    if len(points) < (1 if dots else 2):
        return ""
    points = points[:: max(1, len(points) // 600)]
    lows, highs = zip(*map(_span, zip(*points, *chain(*dashed), strict=True)), strict=True)
    width, height = (end - start for start, end in zip(lows, highs, strict=True))
    scales = (min(630 / width, 150 / height),) * 2 if equal else (630 / width, 150 / height)

    def placed(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        return [(80 + scales[0] * (a - lows[0]), 170 - scales[1] * (b - lows[1])) for a, b in points]

    pixels = placed(points)
    line, *dashed_lines = (" ".join(f"{a:.1f},{b:.1f}" for a, b in part) for part in (pixels, *map(placed, dashed)))
    circles = "".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" class="joint"/>' for a, b in pixels) if dots else ""
    drawn = "".join(f'<polyline points="{part}" class="mark" stroke-dasharray="7 5"/>' for part in dashed_lines)
    drawn += circles or f'<polyline points="{line}" fill="none" stroke="#2f86c5" stroke-width="2"/>'
    low, high = (f"{number(end)}" for end in (lows[0], highs[0]))
    end_labels = [(74, 172, "end", number(lows[1])), (74, 26, "end", number(highs[1])), (80, 192, "start", low)]
    if scales[0] * width < MIN_LABELED:
        end_labels[-1] = (80, 192, "start", f"{low} to {high}")
    else:
        end_labels.append((80 + scales[0] * width, 192, "end", high))
    texts = "".join(f'<text x="{a:.0f}" y="{b}" text-anchor="{side}">{text}</text>' for a, b, side, text in end_labels)
    if loop:
        motion = f'path="M{line}" dur="{loop:.6g}s" rotate="auto" calcMode="linear" repeatCount="indefinite"'
        texts += f'<path class="body moving" d="{BODY}"><animateMotion {motion}/></path>'
    title = f'<text x="80" y="12">{safe(label)}</text>'
    attributes = f'viewBox="-24 -6 784 206" class="curve" font-size="13" role="img" aria-label="{safe(label)}"'
    return f"<svg {attributes}>{drawn}{texts}{title}</svg>"


def computed_svg(pairs: Iterable[tuple[float, float]], what: str, each: str) -> str:
    """Draw (measured, computed) pairs as dots, and the line where both are equal; each: words for one dot."""
    pairs = [pair for pair in pairs if all(map(math.isfinite, pair))]
    if not pairs:
        return ""
    diagonal = [(end, end) for end in _span(chain(*pairs))]
    measured, computed = zip(*pairs, strict=True)
    dots = curve_svg(measured, computed, f"computed over measured {what}", dots=True, dashed=[diagonal])
    return captioned(dots, f"Each dot is {each}; on the dashed line computed equals measured.")


def bars_svg(rows: Iterable[tuple[str, float, float]], label: str) -> str:
    """Draw horizontal bars on an axis that includes 0; rows: name, begin and end of each bar."""
    bars = [row for row in rows if math.isfinite(row[1] + row[2])][:BARS]
    low, high = _span((0.0, *(edge for _, *edges in bars for edge in edges)))
    bottom = 30 + 24 * len(bars)

    def place(value: float) -> float:
        return 410 + 330 * (value - low) / (high - low)

    drawn = f'<path class="mark" d="M{place(0):.1f} 20V{bottom}"/><text x="80" y="12">{safe(label)}</text>'
    for k, (name, *edges) in enumerate(bars):
        y, left, right = 26 + 24 * k, *sorted(map(place, edges))
        drawn += f'<rect class="joint" x="{left:.1f}" y="{y}" width="{max(right - left, 1):.1f}" height="16"/>'
        drawn += f'<text x="398" y="{y + 13}" text-anchor="end">{safe(name)}</text>'
    for value, side in ((low, "start"), (high, "end")):
        drawn += f'<text x="{place(value):.0f}" y="{bottom + 18}" text-anchor="{side}">{number(value)}</text>'
    facts = f'viewBox="-24 -6 784 {bottom + 36}" class="curve" font-size="13" role="img" aria-label="{safe(label)}"'
    return f"<svg {facts}>{drawn}</svg>"


def _span(values: Iterable[float]) -> tuple[float, float]:
    """Return the range of values, widened if all values are equal."""
    values = tuple(values)
    low, high = min(values), max(values)
    margin = 0.0 if low < high else 0.1 * abs(low) or 1.0
    return low - margin, high + margin
