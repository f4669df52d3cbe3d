/// Controller of the core as the app calls it. Its code is compiled apart, for speed; the rest is for size.
#pragma once

#include "hypertuna/pilot/pilot.hpp"

namespace hypertuna::firmware {

void follow(const Pilot<float>& pilot, PilotState<float>& state, const Estimate<float>& at,
            const Readings<float>& readings, ControllerOutput<float>& output);

}  // namespace hypertuna::firmware
