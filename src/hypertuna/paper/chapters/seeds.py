"""The twin over seeds of its sensors' noise."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from hypertuna.actuation.battery import range_of
from hypertuna.arrays import Array
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.chapters.tank import AHEAD, FREQUENCY, PHASE, amplitude_trends, best_phase, frequency_trends
from hypertuna.paper.computed import COSTS, LEVELS, SPEEDS, TANK, TWIN
from hypertuna.paper.ledger import FAMILY, Class, Entry, Finding, judge, published, published_value
from hypertuna.paper.seeds import SEEDS, Stored, all_seeds
from hypertuna.paper.studies import HERTZ, LAKE, LAKE_GAITS, PHASES, STUDIES, phase_name, tank_name
from hypertuna.reports.html import Section, Table

Studies = Mapping[str, Stored]  # by name
BEND = "by the true bend"  # instead of the sensor's reading
AT_SEA = "at sea"
FASTEST = "unoptimised-max"
TANK_HERTZ = np.array(published()["tank"]["frequency_hz"])
# Gaits at 2 and 3 Hz, where the twin's joints are ideal; Table II was read so that ideal joints have their speeds.
READ = ("unoptimised-0.3", "unoptimised-0.4")
SERVOS = "servos as data sheets have them, chosen with this number in view"
FIG_8 = "the family was chosen by this test, and the controller's learning with it in view"
BOUND = "the family was chosen by this bound"


def compute(trials: Trials, full: bool, step: Callable[[], None]) -> Studies:
    """Read the stored studies; in full compute and store them again."""
    return all_seeds(full=full, step=step)


def findings(studies: Studies) -> Iterator[Finding]:
    """Yield the twin's findings on the paper's numbers, from the given studies."""
    kinds: dict[str, Callable[[Stored], Iterator[Finding]]] = {
        "swims": swim_findings,
        "postures": partial(_settling, TWIN),
        "dives": partial(_dive, TWIN),
        "lakes": partial(_lake, f"{TWIN}, {AT_SEA}"),
        "phases": _phases,
        "turns": _turning,
    }
    for study, kind in kinds.items():
        if study in studies:
            yield from kind(studies[study])


def swim_findings(swims: Stored) -> Iterator[Finding]:
    """Yield the findings from straight swims of the twin in the plane."""
    yield from _speeds(TWIN, swims)
    yield from _costs(TWIN, swims)
    yield from _powers(TWIN, swims)
    yield from _tank_trends(TWIN, swims)


def _speeds(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield the eight speeds, and their largest gain."""
    n = stored.numbers
    for name in SPEEDS:
        class_: Class = "in sight" if name in READ else "prediction"
        yield stored.finding(f"speed/{name}", model, class_, n[f"{name} speed"], _reached(stored, name))
    gain = percent(n["unoptimised-max speed"], n["optimised-max speed"])
    yield stored.finding("speed/change-max", model, "prediction", gain, "optimised against unoptimised")


def _costs(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield electrical costs of transport [J/(kg m)]: changes by optimization, the smallest cost, and its frequency."""
    n, mass = stored.numbers, stored.robot.body.mass
    tank = [tank_name(hertz) for hertz in TANK_HERTZ]
    costs = {name: n[f"{name} power"] / (mass * n[f"{name} speed"]) for name in (*SPEEDS, *tank)}
    medians = {name: float(np.median(cost)) for name, cost in costs.items()}
    for speed in COSTS:
        before, after = f"unoptimised-{speed}", f"optimised-{speed}"
        note = f"electrical: {medians[before]:.3g} to {medians[after]:.3g} J/(kg m)"
        gain = percent(costs[before], costs[after])
        yield stored.finding(f"cost-of-transport/change-{speed}", model, "prediction", gain, note)
    cheapest = min(medians, key=lambda name: medians[name])
    note = f"electrical, {cheapest}; at {FASTEST}, the paper's cheapest, {medians[FASTEST]:.3g}; {SERVOS}"
    lowest = np.min(list(costs.values()), axis=0)
    yield stored.finding("cost-of-transport/minimum", model, "in sight", lowest, note)
    note = f"electrical, {', '.join(f'{medians[name]:.3g}' for name in tank)} J/(kg m) from {TANK_HERTZ[0]:g} Hz on"
    cheapest_hertz = TANK_HERTZ[np.argmin([costs[name] for name in tank], axis=0)]
    yield stored.finding(FREQUENCY, model, "prediction", cheapest_hertz, note)


def power_findings(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield the two published powers, and lower bounds of the powers of the gaits for 0.3 to 0.5 m/s."""
    n, lake = stored.numbers, published()["lake"]["gait"]
    note = f"electrical power of all servos; {SERVOS}"
    yield stored.finding("power/fastest", model, "in sight", n[f"{FASTEST} power"], note)
    note = f"{lake} in still water; {SERVOS}"
    yield stored.finding("power/lake", model, "in sight", n[f"{lake} power"], note)
    for speed in COSTS:
        gait = f"unoptimised-{speed}"
        note = f"{gait}, which the model swims at {np.median(n[f'{gait} speed']):.3g} m/s; {BOUND}"
        yield stored.finding(f"power/bound-{speed}", model, "calibrated", n[f"{gait} power"], note)


def _powers(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield powers, the range in the fastest gait, and the lowest pressure."""
    yield from power_findings(model, stored)
    n = stored.numbers
    power, speed = n[f"{FASTEST} power"], n[f"{FASTEST} speed"]
    pairs = zip(power, speed, strict=True)
    ranges = np.array([range_of(stored.robot, power=watts, speed=fast).range / 1e3 for watts, fast in pairs])
    note = f"{FASTEST} on the battery of Table I, at {np.median(power):.3g} W and {np.median(speed):.3g} m/s; {SERVOS}"
    yield stored.finding("range/battery", model, "in sight", ranges, note)
    pressures = {name: n[f"{name} pressure"] for name in (*SPEEDS, *(tank_name(hertz) for hertz in TANK_HERTZ))}
    highest = max(pressures, key=lambda name: float(np.median(pressures[name])))
    note = (
        "gauge, lowest in any cylinder over the eight gaits and the tank tests at large amplitude; the mildest of "
        f"them, {highest}, has {np.median(pressures[highest]):.0f} kPa; {FAMILY}"
    )
    yield stored.finding("pressure/lowest", model, "in sight", np.min(list(pressures.values()), axis=0), note)


def _settling(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield settling times by the bend sensor, the paper's instrument, and by the true bend."""
    n, facts = stored.numbers, published()["posture"]
    note = (
        f"joint {facts['joint']} in air, {facts['angle_deg']:g} deg set, in {facts['duration_s']:g} s; a run that has "
        f"not settled counts to its end; {FIG_8}"
    )
    for name, instrument in ((model, "sensor"), (f"{model}, {BEND}", "bend")):
        times = [n[f"{hertz:g} Hz {instrument}"] for hertz in facts["frequency_hz"]]
        for hertz, time in zip(facts["frequency_hz"], times, strict=True):
            yield stored.finding(f"control/settling-{hertz:g}hz", name, "calibrated", time, note)
        medians = ", ".join(f"{np.median(time):.2g}" for time in times)
        sentence = f"medians of {medians} s from {facts['frequency_hz'][0]:g} Hz on"
        yield stored.finding("control/settling-ratio", name, "in sight", times[-1] / times[0], sentence)


def _lake(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield speed and power of a straight run in the paper's gait, with those of the next slower gait in the notes."""
    n, (paper, slower) = stored.numbers, LAKE_GAITS
    for key, what, unit in (("lake/speed", "speed", "m/s"), ("power/lake", "power", "W")):
        class_: Class = "prediction" if what == "speed" else "in sight"
        note = (
            f"{paper}, straight in still water for {LAKE:g} s; {slower} gives "
            f"{np.median(n[f'{slower} {what}']):.3g} {unit}"
        )
        yield stored.finding(key, model, class_, n[f"{paper} {what}"], note)


def _dive(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield the rate of diving and the range of the pitch."""
    n = stored.numbers
    down, up = (f"{np.median(n[f'{leg} pitch']):+.1f} deg" for leg in ("down", "up"))
    wander = max(n["down pitch range"].max(), n["up pitch range"].max())
    note = (
        f"pitch {down}; then up at {-np.median(n['up rate']):.2g} cm/s, pitch {up}; averaged over beats the pitch "
        f"changes by at most {wander:.1g} deg in the last half of a leg"
    )
    yield stored.finding("diving/depth-rate", model, "not judged", n["down rate"], note)
    extremes = [n[f"{leg} pitch"] + sign * n[f"{leg} pitch range"] / 2 for leg in ("down", "up") for sign in (-1, 1)]
    note = f"from {down} on the way down to {up} on the way up; in the last half of a leg {wander:.1g} deg at most"
    yield stored.finding("diving/pitch-span", model, "prediction", np.ptp(extremes, axis=0), note)


def _tank_trends(model: str, stored: Stored) -> Iterator[Finding]:
    """Yield trends of speed over frequency at large amplitude."""
    n = stored.numbers
    speed = np.array([n[f"{tank_name(hertz)} speed"] for hertz in TANK_HERTZ])  # (frequency, seeds)
    note = f"large amplitude, {', '.join(f'{np.median(one):.3g}' for one in speed)} m/s from {TANK_HERTZ[0]:g} Hz on"
    for key, values in _by_seed(frequency_trends, speed).items():
        yield stored.finding(key, model, "prediction", values, note)


def _by_seed(trends: Callable[..., Mapping[str, float]], *numbers: Array) -> dict[str, Array]:
    """Apply `trends` to the numbers of each seed, along their last axis; return its results by name (seeds,)."""
    rows = [trends(*(one[..., k] for one in numbers)) for k in range(numbers[0].shape[-1])]
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


def _phases(stored: Stored) -> Iterator[Finding]:
    """Yield trends over amplitude, then the fastest and the cheapest phase differences."""
    n, phases = stored.numbers, np.array(PHASES)

    def grid(level: str, what: str) -> Array:  # (frequency, phase, seeds)
        return np.array([[n[f"{phase_name(level, f, p)} {what}"] for p in phases] for f in HERTZ])

    speed_and_power = [np.stack([grid(level, what) for level in LEVELS]) for what in ("speed", "power")]
    note = f"from {' to '.join(LEVELS)} amplitude at {' and '.join(f'{hertz:g}' for hertz in HERTZ)} Hz, {AHEAD}"
    for key, values in _by_seed(amplitude_trends, *speed_and_power).items():
        yield stored.finding(key, TWIN, "prediction", values, note)
    for level in LEVELS:
        speed = grid(level, "speed")
        best = [best_phase(TWIN, level, one, HERTZ).computed for one in np.moveaxis(speed, -1, 0)]
        note = best_phase(TWIN, level, np.median(speed, axis=-1), HERTZ).note
        yield stored.finding(f"optimal-phase/{level}", TWIN, "prediction", np.array(best), note)
    speed = grid(TANK, "speed")
    fastest = np.median(speed, axis=-1).max(axis=1)
    note = ", ".join(f"{fast:.3g} m/s at {hertz:g} Hz" for fast, hertz in zip(fastest, HERTZ, strict=True))
    best_phases = phases[speed.max(axis=0).argmax(axis=0)]
    yield stored.finding("optimal-phase/fastest", TWIN, "prediction", best_phases, f"large amplitude, {note}")
    tested = HERTZ.index(published_value(FREQUENCY))
    ahead = np.where(speed[tested] > 0, speed[tested], np.nan)
    cost = grid(TANK, "power")[tested] / ahead / stored.robot.body.mass
    note = f"electrical, {np.median(np.nanmin(cost, axis=0)):.3g} J/(kg m)"
    yield stored.finding(PHASE, TWIN, "prediction", phases[np.nanargmin(cost, axis=0)], note)


def _turning(stored: Stored) -> Iterator[Finding]:
    """Yield the turning radius at the published phase, and the phase of the tightest turn head first."""
    n, phases = stored.numbers, np.array(published()["turning"]["phase_deg"])
    radius, speed = (np.array([n[f"{phase:g} deg {what}"] for phase in phases]) for what in ("radius", "speed"))
    tested = list(phases).index(published_value("turning/best-phase"))
    middle = np.median(radius, axis=1)
    way = "head first" if np.median(speed[tested]) > 0 else "tail first"
    note = (
        f"strokes that the pressure limit allows; swims {way}; {middle.min():.2f} to {middle.max():.2f} BL over phases"
    )
    yield stored.finding("turning/radius-bl", TWIN, "prediction", radius[tested], note)
    best = phases[np.where(speed > 0, radius, np.inf).argmin(axis=0)]
    yield stored.finding("turning/best-phase", TWIN, "prediction", best, "the tightest head first")


def percent(before: Array, after: Array) -> Array:
    """Return the change between two arrays, in percent of the first."""
    return np.asarray(100 * (after / before - 1))


def _reached(stored: Stored, name: str) -> str:
    """Describe the amplitudes that the joints reach in a gait, and those set."""
    groups = stored.robot.joints
    angles = " and ".join(f"{np.median(stored.numbers[f'{name} swing {group.name}']):.1f}" for group in groups)
    setpoints = " and ".join(f"{np.degrees(angle):.4g}" for angle in stored.robot.gaits[name].amplitude)
    return f"joints reach {angles} of {setpoints} deg"


def sections(studies: Studies) -> list[Section]:
    """Show the seeds."""
    entries = [judge(published(), finding) for finding in findings(studies)]
    speeds = [e for e in entries if e.model == TWIN and e.id.startswith("speed/") and e.unit == "m/s"]
    rms = float(np.sqrt(np.mean([(e.relative_error or 0.0) ** 2 for e in speeds])))
    return compose("seeds", {"seeds": seed_table(entries)}, rms=rms, count=len(SEEDS))


def seed_table(entries: Sequence[Entry]) -> Table:
    """Tabulate medians, spreads and pass rates."""
    rows = [
        [
            one.id,
            one.model,
            one.published_text,
            one.computed_text,
            f"{one.seeds.low:.3g} to {one.seeds.high:.3g}",
            one.seeds_text,
        ]
        for one in entries
        if one.seeds is not None
    ]
    return Table(["number", "model", "published", "median", "5 to 95 %", "seeds that agree"], rows)


CHAPTER = Chapter("seeds", sections, findings, compute, full_steps=1 + len(STUDIES))
