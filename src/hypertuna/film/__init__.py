"""Film: joint angles and head poses of a robot from a film of it, seen from above.

camera, calibrate: map pixels to places at the fish's depth; calibrate the camera with a checkerboard or tank corners.
numbers: read small CSV files of numbers.
source, view: read frames and their times; find the empty tank, and the pixels that differ from it.
record, pace: record a live camera; detect slow motion.
sections, widths: the silhouette of a robot from its sections; widths learned from a film.
states, track: states of a tracked frame; first guesses of the pose, and tracking from frame to frame.
dots, tags, marks: track colored dots or ArUco tags instead of the silhouette.
blinks: synchronize the clocks of log and film by a blinking lamp.
noise: the beat fitted to the joint angles; the noise of ripples and its correlation time.
run, overlay, plots: the tracked run, split where films were joined; its files, and its pictures.
"""
