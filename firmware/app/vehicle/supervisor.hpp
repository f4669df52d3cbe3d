/// Supervisor: detects the faults that controller and pilot cannot know of.
#pragma once

#include "app/vehicle/faults.hpp"
#include "app/vehicle/parameters.hpp"
#include "app/vehicle/states.hpp"

namespace hypertuna::firmware {

inline constexpr float sensor_after = 1.0f;  // s until a depth, or its absence, is believed
inline constexpr float radio_depth = 0.3f;   // m of the nose from which water over the antenna stops the radio

struct SupervisorState {
    Faults present, latched;
    int low, empty, tilted, leaking, blind, deep;  // ticks that the condition has lasted
};

/// Input of a tick.
struct SupervisorInput {
    const ControllerState<float>& controller;
    const Status& status;
    const Estimate<float>& at;
    bool leak, overrun, lost_records;
    State state;
    float silence;  // s without the ground station, where it could be received
};

/// Count the ticks that a condition lasts; whether it has lasted for `seconds`.
inline bool lasting(int& ticks, bool holds, float seconds, float tick) {
    ticks = !holds ? 0 : float(ticks) * tick < seconds ? ticks + 1 : ticks;
    return holds && seconds <= float(ticks) * tick;
}

/// One tick: update the present faults, and those latched since arming.
inline void detect_faults(const Model& model, SupervisorState& memory, const SupervisorInput& input) {
    const Controller<float>& controller = model.pilot.controller;
    const Limits& limits = model.limits;
    const float tick = controller.tick;
    Faults& now = memory.present;
    const auto says = [&](Condition c) { return input.status.has(c); };
    bool bend = false, pressure = false, current = false;
    for (int j = 0; j < controller.joints; ++j) bend = bend || input.controller.bend[j].faulty;
    for (int c = 0; c < 2 * controller.joints; ++c) {
        pressure = pressure || input.controller.pressure[c].faulty;
        current = current || input.controller.current[c].faulty;
    }
    const Health<float>& battery = input.controller.voltage;
    const bool known = battery.seen && !battery.faulty;
    const float supply = input.controller.supply;
    now.set(Fault::over_pressure, says(Condition::hard_stop));
    now.set(Fault::bend_sensor, bend);
    now.set(Fault::pressure_sensor, pressure);
    now.set(Fault::current_sensor, current);
    now.set(Fault::imu, !imu_stands(input.controller));
    now.set(Fault::battery_sensor, battery.faulty);
    now.set(Fault::low_battery,
            lasting(memory.low, known && supply < controller.voltage_low, limits.voltage_after, tick));
    now.set(Fault::empty_battery,
            lasting(memory.empty, known && supply < limits.voltage_empty, limits.voltage_after, tick));
    now.set(Fault::link_lost, limits.link_timeout < input.silence);
    now.set(Fault::link_gone, input.state != State::disarmed && limits.home_timeout < input.silence);
    const float pitch = input.at.facing.z, roll = input.at.tilt, limit = limits.tilt_max;
    const Quaternion<float>& q = input.at.q;
    const bool over = 0.5f < q.x * q.x + q.y * q.y;  // on its back, where both sines are small again
    const bool tilted = input.at.attitude && (over || !(abs(pitch) <= limit && abs(roll) <= limit));
    now.set(Fault::tilt, lasting(memory.tilted, tilted, limits.tilt_after, tick));
    now.set(Fault::leak, lasting(memory.leaking, input.leak, limits.leak_after, tick));
    now.set(Fault::overrun, input.overrun);
    now.set(Fault::depth_sensor, lasting(memory.blind, !input.at.depths, sensor_after, tick));
    const bool hull = by_ground(input.state) || input.state == State::surface;
    const bool too_deep = hull && input.at.depths && limits.depth_max < input.at.depth;
    now.set(Fault::too_deep, lasting(memory.deep, too_deep, sensor_after, tick));
    now.set(Fault::black_box, input.lost_records);
    for (int f = 0; f < faults; ++f)
        if (fault_texts[f].latched && now.has(Fault(f))) memory.latched.set(Fault(f), true);
}

/// All present and latched faults.
inline Faults all_faults(const SupervisorState& memory) { return {memory.present.flags | memory.latched.flags}; }

}  // namespace hypertuna::firmware
