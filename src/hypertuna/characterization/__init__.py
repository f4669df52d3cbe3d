"""An actuator from its test bench."""
