"""Trials: read tank runs, and compare them with the model.

steady, numbers, decay, tables, tracks, manifest, importers, radio_log: read one file; trials: read any files.
reach: ranges of frequency, amplitude and speed that runs cover.
kind, kind_steady, kind_tracked, kind_numbers, kind_decay, kinds: how each kind of trial is fitted, listed and drawn.
points, grid, form, form_poses, form_captures, form_columns, forms: read tracked points from text files of many forms.
form_arrays, form_hdf5, form_matlab, form_c3d, form_numpy, form_workbook: read tracked points from binary files.
pose_import: import poses and joint angles of other programs.
clock, swimming_plane, markers: times of tracked points, their swimming plane, and which of them count as seen.
chain, marker_places, marker_order, marker_run, marker_import, plots_markers: convert markers to joint angles and head
poses.
plausibility: warn of runs far from the model.
start, smoothing, replay, comparison: how a run begins; smooth joint angles, replay them with the model, and compare
with the tracks.
plots, plots_series, cards: figures and cards.
"""
