#include "app/vehicle/controller.hpp"

namespace hypertuna::firmware {

void run_controller(const Pilot<float>& pilot, PilotState<float>& state, const Estimate<float>& at,
                    const Readings<float>& readings, ControllerOutput<float>& output) {
    act(pilot, state, at, readings, output);
}

}  // namespace hypertuna::firmware
