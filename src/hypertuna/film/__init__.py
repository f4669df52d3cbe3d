"""Film: joint angles and head poses of a robot from a film of it, seen from above.

camera, calibrate: map pixels to places at the fish's depth; calibrate the camera with a checkerboard or tank corners.
numbers: read small CSV files of numbers.
source, view: read frames and their times; find the empty tank, and the pixels that differ from it.
record, pace: record a live camera; detect slow motion.
sections, widths: the silhouette of a robot from its sections; widths learned from a film.
first, states, track, takes: first guesses of the pose; states of a tracked frame; tracking from frame to frame;
splitting a film that was joined from several.
dots, tags, marks: track colored dots or ArUco tags instead of the silhouette.
blinks: synchronize the clocks of log and film by a blinking lamp.
noise: the beat fitted to the joint angles; the noise of ripples and its correlation time.
run, overlay, plots: the tracked run, its files, and its pictures.
"""
