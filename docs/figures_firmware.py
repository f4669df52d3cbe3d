"""Tables of docs/firmware.md, from the firmware's tables of states, orders, needs and faults."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from figures_common import rows

from hypertuna import _core

STATES = [name for name, *_ in _core.state_table()]
LOCKSTEP: dict[str, Any] = json.loads(  # written by measure.py beside it
    (Path(__file__).parents[1] / "validation/lockstep/lockstep.json").read_text()
)
EVENTS = [row[0] for row in _core.order_table()].index("stop")  # index of the first event among the orders


def state_table() -> str:
    """Tabulate the states with their numbers in MAVLink."""
    body = [
        [f"`{name}`", str(_core.MODE_BASE + k) if k else f"{_core.MODE_BASE + 1}, not armed", sentence, order and "yes"]
        for k, (name, sentence, order) in enumerate(_core.state_table())
    ]
    return rows(["state", "custom_mode", "the robot", "selected as a mode"], body, 4)


def transition_table(events: bool) -> str:
    """Tabulate what follows from each order, or each event on board, in each state."""
    part = _core.order_table()[EVENTS:] if events else _core.order_table()[:EVENTS]
    body = [[f"`{name}`", *(_cell(cell) for cell in cells)] for name, *_, cells in part]
    return rows(["event" if events else "order", *STATES], body, len(STATES) + 1)


def _cell(cell: str) -> str:
    """Write a cell: the next state in bold, a refusal in italics, a dot where nothing changes."""
    return "·" if not cell else f"*{cell[1:]}*" if cell[0] == "!" else f"**{cell}**"


def order_table() -> str:
    """Tabulate orders and events with their meanings, senders and needs."""
    body = [
        [f"`{name}`", sentence, who, ", ".join(f"`{need}`" for need in needs)]
        for name, sentence, who, needs, _ in _core.order_table()
    ]
    return rows(["order or event", "meaning", "from", "needs"], body, 4)


def need_table() -> str:
    """Tabulate the needs of orders, and when each holds."""
    return rows(["need", "holds if"], [[f"`{name}`", sentence] for name, sentence in _core.need_table()], 2)


def fault_table() -> str:
    """Tabulate the faults."""
    body = [
        [
            f"`{name}`",
            sentence,
            answer,
            choice and f"`{choice}`",
            *("yes" if is_so else "" for is_so in flags),
            severity,
        ]
        for name, sentence, answer, *flags, severity, choice in _core.fault_table()
    ]
    return rows(
        ["fault", "meaning", "response", "chosen by", "latched until armed again", "forbids arming", "severity"],
        body,
        7,
    )


def lockstep_table() -> str:
    """Tabulate the runs on the emulated board: maxima of instructions per tick."""
    body = [
        [
            f"`{robot}`",
            label,
            f"{run['ticks']:,}",
            "" if run["differ"] is None else str(run["differ"]),
            *(f"{run[part]:,}" for part in ("controller", "pilot", "radio", "whole")),
            f"{run['stack']:,} B",
        ]
        for robot, found in LOCKSTEP.items()
        for label, run in found["runs"].items()
    ]
    heads = ["robot", "run", "ticks", "differ", "controller", "pilot", "radio", "vehicle", "stack"]
    return rows(heads, body, 2)


def size_table() -> str:
    """Tabulate the sizes of each robot's firmware."""
    body = [
        [
            f"`{robot}`",
            *(str(found["sizes"][key]) for key in ("joints", "numbers", "parameters")),
            *(f"{found['sizes'][key] / 1024:.1f} kB" for key in ("text", "data")),
        ]
        for robot, found in LOCKSTEP.items()
    ]
    return rows(["robot", "joints", "numbers on board", "of them parameters", "program text", "data"], body)


TABLES: dict[str, Callable[[], str]] = {
    "states": state_table,
    "orders": lambda: transition_table(events=False),
    "events": lambda: transition_table(events=True),
    "meanings of orders": order_table,
    "needs": need_table,
    "faults": fault_table,
    "lock-step": lockstep_table,
    "sizes of firmware": size_table,
}
PICTURES: dict[str, Callable[[], object]] = {}
