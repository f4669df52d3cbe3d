"""Film: joint angles and head poses of a robot from a film of it, seen from above.

camera, calibrate: pixels into places at the fish's depth, through lens and water; the camera from a board or corners.
numbers: small tables of them.
source, view: frames of a film and their times; the empty tank, and what differs from it.
record, pace: a live camera into a film; slow motion.
sections, widths: the sections of a robot from nose to tail, and its silhouette; widths learned from a film.
first, states, track, takes: where the fish is before anything is known of it; what may come of a frame; frame by frame;
films that were joined.
dots, tags, marks: colored dots and ArUco tags in place of the outline, as tracked points.
blinks: a lamp that blinks, for the clock of logs.
noise: what a periodic motion leaves: the noise of ripples, and its memory.
run, overlay, plots: what was found, its files, and its pictures.
"""
