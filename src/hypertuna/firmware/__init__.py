"""The firmware's numbers from a robot's description, and the programs that run the firmware with a twin.

parameters (numbers from the description), header (C++ header of a robot, with descriptions of its parameters),
lockstep (messages with a twin), boards, scenario, channel and relay (the modeled radio), in_the_loop, black_box,
failures, wiring of the board, and plots (its figure).
"""
