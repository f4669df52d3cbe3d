"""Firmware and what runs it.

parameters (numbers from the description), metadata (descriptions of the parameters), lockstep (messages with a twin),
boards, scenario, channel and relay (the modeled radio), in_the_loop, black_box.
"""
