"""Swimming: from a gait to its settled beat, and everything computed from it.

In reading order: `gait_checks` (of values and axes), `gait` (one harmonic per joint group; lists and grids), `model`
(the core's model of a robot and the names of its parameters), `yielding` (hinges in the settled beat), `designs` (how
beats follow the numbers of a robot's file), `beat` (settled beats and their derivatives), `swim` (one gait),
`trajectory` (its motion), `band` (speeds within what is uncertain), `batch`, `sweep` and `shards` (many gaits,
gradients), `turn` (turning circles), `outline` (the body as shapes); figures in `plots`, `plots_gait`, `plots_turn`,
`animation`; `cards`, `cards_sweep` (what is shown).
"""
