"""Firmware parameters, lock-step, boards, firmware in the loop, black box."""
