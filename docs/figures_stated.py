"""Numbers of the ledger in the sentences of the pages: each has one home, and docs/figures.py writes it from there.

In a sentence below, {id | model} stands for a computed number, {low id | model} and {high id | model} for the ends of
the family's range, and {rms | model} for the error of the eight speeds. Each sentence stands on a page.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

from hypertuna.paper.reproduce import Ledger

SENTENCES = (  # sentences of the pages; {name | model} stands for a number of the paper's ledger
    "90 % of the robots that the paper allows swim {low speed/unoptimised-max | twin} to "
    "{high speed/unoptimised-max | twin} m/s; 0.56 m/s is published",
    "the optimized gait changes the speed by {speed/change-max | joint bandwidth} % with joint bandwidth, and by "
    "{speed/change-max | twin} % in the twin",
    "In the twin the speed rises in {speed/over-frequency | twin} % of the steps of frequency",
    "In the twin, {optimal-phase/small | twin} deg is best at small and {optimal-phase/large | twin} deg at large",
    "In the tank tests the twin is cheapest at {cost-of-transport/cheapest-hz | twin} Hz; its lowest cost of all gaits "
    "is {cost-of-transport/minimum | twin} J/(kg m)",
    "The default robot takes {power/bound-0.3 | twin}, {power/bound-0.4 | twin} and {power/bound-0.5 | twin} W",
    "In the twin the costs change by {cost-of-transport/change-0.3 | twin}, {cost-of-transport/change-0.4 | twin} and "
    "{cost-of-transport/change-0.5 | twin} %",
    "Finite elements, which have no friction, give {fe/bending-I | finite elements} and "
    "{fe/bending-II | finite elements} deg. The fast model gives {bending/I | actuator} and {bending/II | actuator} "
    "deg with friction. Its slopes from 200 to 250 kPa are {bending/linear-I | actuator} and "
    "{bending/linear-II | actuator} times",
    "The slopes from 200 to 250 kPa are {bending/linear-I | actuator} (I) and {bending/linear-II | actuator} (II) "
    "times those from 100 to 150 kPa; by finite elements, {bending/linear-I | finite elements} and "
    "{bending/linear-II | finite elements} times",
    "some cylinder falls to {pressure/lowest | twin} kPa",
    "the default robot's median is {control/settling-1hz | twin} s at 1 Hz and {control/settling-6hz | twin} s at 6 Hz",
    "In the twin it falls only up to {cost-of-transport/cheapest-hz | twin} Hz",
    "The electrical cost of the twin falls in {cost-of-transport/over-amplitude | twin} % of the comparisons",
    "The working pressure needs {servo/torque-6hz-I | pump sizing} times the torque",
    "In the twin the pitch of both ways together spans {diving/pitch-span | twin} deg",
    "In still water the twin swims {lake/speed | twin, at sea} m/s instead of 0.444 m/s, and takes "
    "{power/lake | twin, at sea} W instead of 18.2 W",
    "It turns at {turning/radius-bl | twin} BL at 200 deg, and its tightest turn head first is at "
    "{turning/best-phase | twin} deg",
    "The twin takes {power/fastest | twin} and {power/lake | twin} W in these gaits. The speed of its fastest gait is "
    "{speed/unoptimised-max | twin} m/s",
    "ideal joints miss a speed by up to {speed/model-error-max | ideal joints} % and a cost by up to "
    "{cost-of-transport/model-error | ideal joints} %",
    "The phase deviates: {optimum/max/phase | ideal joints} deg with ideal joints, "
    "{optimum/max/phase | joint bandwidth} deg with joint bandwidth",
    "the radius at 200 deg is {turning/radius-bl | joint bandwidth, feasible stroke} BL",
    "Among the gaits that swim head first, {turning/best-phase | joint bandwidth} deg is the tightest",
    "Up to {cost-of-transport/cheapest-hz | twin} Hz it falls, because the idle power",
    "The default robot of the twin has an rms error of {rms | twin} %",
)
NUMBER = r"[-+]?\d[\d.]*"  # pattern of a number in a sentence


def pattern_of(sentence: str) -> str:
    """Return a regular expression of a sentence with any numbers; its groups are the words around them."""
    parts = [r"\s+".join(map(re.escape, words.split(" "))) for words in re.split(r"\{.+?\}", sentence)]
    return NUMBER.join(f"({part})" for part in parts)


def stated(page: str, ledger: Callable[[], Ledger]) -> str:
    """Return a page with the numbers in its sentences written anew."""
    for sentence in SENTENCES:
        page = re.sub(pattern_of(sentence), partial(_with_numbers, sentence, ledger), page)
    return page


def _with_numbers(sentence: str, ledger: Callable[[], Ledger], found: re.Match[str]) -> str:
    """Return a sentence found on a page, with the numbers of the ledger."""
    numbers = [*(_told(ledger(), name) for name in re.findall(r"\{(.+?)\}", sentence)), ""]
    return "".join(words + number for words, number in zip(found.groups(), numbers, strict=True))


def _told(ledger: Ledger, name: str) -> str:
    """Write a number of the ledger as its table has it."""
    key, model = name.split(" | ")
    end, _, key = key.rpartition(" ")
    if key == "rms":
        numbers = {"": f"{100 * ledger.summary['speeds'][model]['rms_relative_error']:.1f}"}
    else:
        (entry,) = [entry for entry in ledger.entries if (entry.id, entry.model) == (key, model)]
        numbers = {"": entry.computed_text} | dict(zip(("low", "high"), entry.band_text.split(" to "), strict=False))
        if not numbers.get(end):
            raise ValueError(f"{name} is on a page and has no number: {entry.note}")
    return numbers[end]
