"""Trials: tank runs, read and compared with the model.

steady, numbers, decay, tables, tracks, manifest, importers, radio_log: the files, and trials: all of them together.
reach: the ranges of runs.
kind, kind_steady, kind_tracked, kind_numbers, kind_decay, kinds: what a kind adds to a fit, to tables and to figures,
and the list of kinds.
points: tracked points as files hold them.
markers, marker_places, chain, marker_import, plots_markers: tracked markers into joint angles and head poses.
plausibility: runs far from the model.
start, smoothing, replay, comparison: how a run begins; joint angles as functions of time, swum by the model, and
compared with the tracks.
plots, plots_series, cards: figures, and what is shown.
"""
