"""Scoreboard: published swimmers beside what hypertuna predicts of them.

In reading order: `swimmers` (their files), `prediction` (a first robot of what is published, its gaits and speeds),
`fits` (one drag area, fitted to one speed), `laws` (that all swimmers obey, and random fish), `scores` (published
beside predicted, and what they say), `scoreboard` (all swimmers); figures in `plots`; `cards` (what is shown).
"""
