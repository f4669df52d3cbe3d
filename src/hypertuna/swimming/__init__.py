"""Swimming: from a gait to its settled beat, and everything computed from it.

In reading order: `gait_checks` (checks of gaits and grids), `gait` (one harmonic per joint group; lists and grids),
`model` (the core's model of a robot and the names of its parameters), `yielding` (hinges in the settled beat),
`designs` (derivatives with respect to numbers of a robot's file), `beat` (settled beats and their derivatives), `swim`
(one gait), `trajectory` (the motion of a swim), `band` (range of speed by uncertain estimates), `batch`, `sweep` and
`shards` (many gaits, gradients), `turn` (turning circles), `outline` (the body as shapes); figures in `plots` and
`plots_turn`; text in `cards`, `cards_sweep`.
"""
