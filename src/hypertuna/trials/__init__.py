"""Trials: read tank runs, and compare them with the model.

steady, numbers, decay, tables, tracks, manifest, importers, radio_log: the files. trials: the runs of all files.
reach: the ranges of runs.
kind, kind_steady, kind_tracked, kind_numbers, kind_decay, kinds: what a kind adds to a fit, to tables and to figures,
and the list of kinds.
points, grid, form, form_clock, form_poses, form_captures, form_columns, form_headed, form_shapes, forms: tracked
points as files of many forms hold them.
form_hdf5, form_matlab, form_c3d, form_numpy, form_workbook, form_json: the other forms.
pose_table, pose_import: poses and joint angles of other programs.
clock, markers: their times, the swimming plane, and which points count as seen.
chain, marker_places, marker_run, marker_import, plots_markers: markers into joint angles and head poses.
head_motion: motions that no body makes.
plausibility, plausible_numbers: runs far from the model, and columns of any kind of run in another unit.
start, smoothing, replay, comparison: how a run begins; joint angles as functions of time, swum by the model, and
compared with the tracks.
plots, plots_series, cards: figures, and what is shown.
"""
