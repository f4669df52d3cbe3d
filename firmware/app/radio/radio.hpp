/// Radio: the robot's side of MAVLink, compiled apart for size; the controller is compiled for speed.
#pragma once

#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

void boot(Radio& radio, const Vehicle& vehicle);

/// One tick of the radio: take the bytes received since the last tick, act on their frames, and fill radio.out with
/// answers and telemetry.
void tick(Radio& radio, Vehicle& vehicle, const std::uint8_t* bytes, int count);

}  // namespace hypertuna::firmware
