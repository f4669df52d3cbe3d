/// Controller of the core, compiled apart for speed; the rest is compiled for size.
#pragma once

#include "hypertuna/pilot/pilot.hpp"

namespace hypertuna::firmware {

void run_controller(const Pilot<float>& pilot, PilotState<float>& state, const Estimate<float>& at,
                    const Readings<float>& readings, ControllerOutput<float>& output);

}  // namespace hypertuna::firmware
