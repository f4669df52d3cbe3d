"""Firmware and what runs it.

parameters (numbers from the description), lockstep (messages with a twin), boards, scenario, channel and relay (the
modeled radio), in_the_loop, black_box.
"""
