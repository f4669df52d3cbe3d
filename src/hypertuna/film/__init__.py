"""Film: joint angles and head poses of a robot from a film of it, seen from above.

camera, calibrate: pixels into places at the fish's depth, through lens and water; the camera from a board or corners.
source: frames of a film, their times, and the empty tank.
sections, body: the sections of a robot from nose to tail, and its silhouette.
first: where the fish is, before anything is known of it.
track: frame by frame, and all frames together.
noise: what a periodic motion leaves: the noise of ripples, and its memory.
run, overlay, plots: what was found, its files, and its pictures.
"""
