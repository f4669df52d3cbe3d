/// Supervisor: watches what the controller and the pilot cannot know of, and turns everything that fails into one
/// answer.
#pragma once

#include "app/vehicle/faults.hpp"
#include "app/vehicle/parameters.hpp"

namespace hypertuna::firmware {

struct SupervisorMemory {
    Faults present, latched;
    int low, empty, tilted, leaking;  // ticks that it lasted
};

/// What it hears of in a tick.
struct Heard {
    const ControllerState<float>& controller;
    const Status& status;
    const Estimate<float>& at;
    bool leak, overrun, lost_records;
    bool armed;
    float silence;  // s since the ground was heard
};

/// Count the ticks that something lasts, and say whether that is long.
inline bool lasting(int& ticks, bool holds, float seconds, float tick) {
    ticks = !holds ? 0 : float(ticks) * tick < seconds ? ticks + 1 : ticks;
    return holds && seconds <= float(ticks) * tick;
}

/// One tick: the faults that hold now, and those that did since it was armed.
inline void watch(const Model& model, SupervisorMemory& memory, const Heard& heard) {
    const Controller<float>& controller = model.pilot.controller;
    const Limits& limits = model.limits;
    const float tick = controller.tick;
    Faults& now = memory.present;
    const auto says = [&](Condition c) { return heard.status.has(c); };
    bool bend = false, pressure = false, current = false;
    for (int j = 0; j < controller.joints; ++j) bend = bend || heard.controller.bend[j].faulty;
    for (int c = 0; c < 2 * controller.joints; ++c) {
        pressure = pressure || heard.controller.pressure[c].faulty;
        current = current || heard.controller.current[c].faulty;
    }
    const Health<float>& battery = heard.controller.voltage;
    const bool known = battery.seen && !battery.faulty;
    const float supply = heard.controller.supply;
    now.set(Fault::over_pressure, says(Condition::hard_stop));
    now.set(Fault::bend_sensor, bend);
    now.set(Fault::pressure_sensor, pressure);
    now.set(Fault::current_sensor, current);
    now.set(Fault::imu, !imu_stands(heard.controller));
    now.set(Fault::battery_sensor, battery.faulty);
    now.set(Fault::low_battery,
            lasting(memory.low, known && supply < controller.voltage_low, limits.voltage_after, tick));
    now.set(Fault::empty_battery,
            lasting(memory.empty, known && supply < limits.voltage_empty, limits.voltage_after, tick));
    now.set(Fault::link_lost, limits.link_timeout < heard.silence);
    now.set(Fault::link_gone, heard.armed && limits.home_timeout < heard.silence);
    const float pitch = heard.at.facing.z, roll = heard.at.tilt, most = limits.tilt_most;
    const Quaternion<float>& q = heard.at.q;
    const bool over = 0.5f < q.x * q.x + q.y * q.y;  // on its back, where both sines are small again
    const bool tilted = heard.at.attitude && (over || !(abs(pitch) <= most && abs(roll) <= most));
    now.set(Fault::tilt, lasting(memory.tilted, tilted, limits.tilt_after, tick));
    now.set(Fault::leak, lasting(memory.leaking, heard.leak, limits.leak_after, tick));
    now.set(Fault::overrun, heard.overrun);
    now.set(Fault::black_box, heard.lost_records);
    for (int f = 0; f < faults; ++f)
        if (fault_texts[f].latched && now.has(Fault(f))) memory.latched.set(Fault(f), true);
}

/// All that holds, or did and is remembered.
inline Faults all(const SupervisorMemory& memory) { return {memory.present.flags | memory.latched.flags}; }

}  // namespace hypertuna::firmware
