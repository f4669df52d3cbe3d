#include "app/vehicle/controller.hpp"

#include <new>

namespace hypertuna::firmware {

void run_controller(const Pilot<float>& pilot, PilotState<float>& state, const Estimate<float>& at,
                    const Readings<float>& readings, ControllerOutput<float>& output) {
    new (&output) ControllerOutput<float>(act(pilot, state, at, readings));  // in place
}

}  // namespace hypertuna::firmware
