"""Trials: tank runs, read and compared with the model.

steady, tracks, manifest, importers, radio_log: the files, and trials: all of them together.
markers, marker_places, chain, marker_import, marker_plots: tracked markers into joint angles and head poses.
plausibility: runs far from the model.
smoothing, replay, comparison: joint angles as functions of time, swum by the model, and compared with the tracks.
plots, cards: figures, and what notebooks show.
"""
