"""The firmware's numbers from a robot's description, and the programs that run the firmware with a twin.

parameters (numbers from the description), metadata (descriptions of the parameters), header (C++ header of a robot),
lockstep (messages with a twin), boards, scenario, channel and relay (the modeled radio), in_the_loop, black_box, and
failures, wiring of the board; plots (its figure).
"""
