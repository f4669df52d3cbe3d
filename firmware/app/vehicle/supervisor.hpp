/// Supervisor: detects the faults that controller and pilot cannot know of.
#pragma once

#include "app/vehicle/faults.hpp"
#include "app/vehicle/parameters.hpp"
#include "app/vehicle/states.hpp"

namespace hypertuna::firmware {

inline constexpr float sensor_after = 1.0f;  // s until a depth, or its absence, is believed
inline constexpr float trim_after =
    10.0f;  // s after which a disarmed robot's sinking is judged anew: hands may move it
inline constexpr float trim_coast =
    1.2f;  // largest mean rate of a sinking robot over its present rate; one that coasts down slows by more
inline constexpr float stroke_bend = 0.65f;  // part of the swing asked; a joint that bends less does not follow
inline constexpr float stroke_pressure =
    0.25f;  // part of the working pressure: a stroke brings more, and its end leaves less than twice that
inline constexpr float stroke_bias = 0.25f;  // part of the amplitude; with more bias a joint is not judged
inline constexpr int stroke_beats = 3;       // beats in a row in which a joint does not follow
inline constexpr float stroke_empty =
    0.5f;  // part of the fill pressure: with oil, each side's pressure passes the fill pressure in each beat
inline constexpr float snag_reach =
    0.25f;  // part of snag_distance: a robot that stays within this of a fix makes no way
inline constexpr float snag_errors = 2.0f;  // standard deviations of a fix that `snag_reach` is at least
inline constexpr float snag_straight =
    0.7f;  // least part of the way swum that is straight, on a course; a robot that circles has less
inline constexpr float snag_circles =
    2.0f;  // times snag_distance: after such a distance on one leg the robot is not circling
inline constexpr float radio_depth = 0.3f;  // m, depth of the nose from which water over the antenna stops the radio

/// Lowest and highest value within a beat.
struct Extent {
    float low, high;
    void add(float x, bool first) { low = first ? x : min(low, x), high = first ? x : max(high, x); }
    float swing() const { return high - low; }
};

/// Way swum since a fix, to see whether the robot moves over ground.
struct Headway {
    float from[2];      // m
    float straight[2];  // m through the water, as a vector
    float swum;         // m, along its path
    float on_leg;       // m of `swum` on the present leg
    int leg;
    bool begun;
};

/// Least depth of a robot at rest, which is set anew once the robot has sunk by twice the limit, and how long ago the
/// robot was there.
struct Rest {
    float depth;       // m
    int ticks, since;  // ticks at rest, while disarmed of the last seconds; since the robot was at that depth
    bool sinks, sank;  // whether the robot sank in these seconds, and in those before
};

/// What was asked of a joint and what its sensors showed within a beat.
struct Stroke {
    Extent asked, bend, pressure[2];  // rad, Pa
    int ticks, missing;               // ticks of the beat; beats in a row in which the joint did not follow
};

struct SupervisorState {
    Faults present, latched;
    int low, empty, tilted, blind, deep;  // ticks for which each condition has lasted
    float leaking, unguarded;             // s for which it has, less a part of the gaps: see `recurs`
    Headway way;
    Rest rest;
    Stroke stroke[max_joints];
    bool released[max_joints];  // joints that do not follow
};

/// Input of a tick.
struct SupervisorInput {
    const ControllerState<float>& controller;
    const ControllerOutput<float>& output;
    const Estimate<float>& at;
    const PilotReadings<float>& readings;
    bool leak, overrun, lost_records;
    bool still, driven;  // the tail rests; the beat is meant to move the robot
    State state;
    int leg;        // leg of the pilot; -1 where it is on none, or may circle
    float silence;  // s without the ground station, where it could be received
};

/// Count the ticks for which a condition lasts, and return whether it has lasted for `seconds`.
inline bool lasting(int& ticks, bool holds, float seconds, float tick) {
    ticks = !holds ? 0 : float(ticks) * tick < seconds ? ticks + 1 : ticks;
    return holds && seconds <= float(ticks) * tick;
}

inline constexpr float gap_weight = 0.1f;  // weight of time without a condition, relative to time with it

/// Whether a condition has lasted for `seconds` in spite of gaps, as where water sloshes over a probe or a contact is
/// loose: it must hold for more than a tenth of the time. What `was` present ends after a gap of ten times `seconds`.
inline bool recurs(float& held, bool was, bool holds, float seconds, float tick) {
    held = holds ? min(held + tick, seconds) : max(held - gap_weight * tick, 0.0f);
    return seconds <= held || (was && 0.0f < held);
}

/// Whether the robot swims on a course, or for long on one leg, and stays where it is, as fixes show.
inline bool makes_no_way(Headway& way, const Limits& limits, const SupervisorInput& input, float tick) {
    const Estimate<float>& at = input.at;
    if (input.state == State::disarmed) way = {};
    if (input.leg != way.leg) way.leg = input.leg, way.on_leg = 0;
    if (input.driven) {
        const float step = at.speed / at.factor * tick;
        way.swum += abs(step), way.on_leg += abs(step);
        way.straight[0] += step * at.facing.x, way.straight[1] += step * at.facing.y;
    }
    const PilotReadings<float>& readings = input.readings;
    if (!readings.fixed || limits.snag_distance == 0.0f) return false;
    // Where fixes are so poor that they cannot tell, the robot is judged after a longer way.
    const float reach = max(snag_reach * limits.snag_distance, snag_errors * readings.accuracy);
    const float distance = reach / snag_reach;
    const auto square = [](float x, float y) { return x * x + y * y; };
    const float straight = square(way.straight[0], way.straight[1]), course = snag_straight * way.swum;
    const bool far = distance * distance < straight;
    const bool stays_near =
        way.begun && square(readings.fix[0] - way.from[0], readings.fix[1] - way.from[1]) < reach * reach;
    const float longest = snag_circles * distance;
    const bool by_leg = 0 <= way.leg;
    if (stays_near && ((far && course * course < straight) || (by_leg && longest < way.on_leg))) return true;
    // A fix that the pilot refuses proves nothing, unless it is where the robot was.
    if (at.fix && (!stays_near || (!by_leg && longest < way.swum)))
        way = {{readings.fix[0], readings.fix[1]}, {}, 0, 0, way.leg, true};
    return false;
}

/// Whether a joint with oil does not follow for some beats. It bends by much less than its pumps were sent to, which is
/// what the limits leave of what was asked; and a side's pressure does not rise, as without oil, or does not fall, as
/// where its servo stands. Lost oil contradicts the model of bend and pressure, so the sensors of both may count as
/// faulty first. If the readings of both go on, and one side's pressure stays far below the fill pressure, oil is
/// missing, and not two sensors.
inline bool has_no_stroke(const Controller<float>& model, Stroke& stroke, const SupervisorInput& input, int j) {
    const ControllerState<float>& state = input.controller;
    const bool first = stroke.ticks++ == 0;
    stroke.asked.add(state.bend_sent[j], first), stroke.bend.add(input.readings.robot.bend[j], first);
    bool dead = false, empty = false, goes_on = true;
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        stroke.pressure[side].add(input.readings.robot.pressure[c], first);
        const float fill = model.circuit[c].fill, part = stroke_pressure * (model.pressure_work - fill);
        const Extent& extent = stroke.pressure[side];
        dead = dead || extent.high < fill + part || fill + 2 * part < extent.low;
        empty = empty || extent.high < stroke_empty * fill;
        goes_on = goes_on && 0 < extent.swing();
    }
    if (!state.posture[j].ended) return stroke_beats <= stroke.missing;
    // A bias takes up a part of the joint's reach, and holds one side's pressure.
    const bool even = abs(state.bias[j].value) < stroke_bias * state.amplitude[j].value;
    const bool asked = even && 2 * model.posture.amplitude_min < stroke.asked.swing();
    const bool follows = stroke_bend * stroke.asked.swing() < stroke.bend.swing();
    const bool bend = state.bend[j].faulty, pressure = blind(state, j);
    const bool fails =
        bend || pressure ? bend && pressure && empty && goes_on && 0 < stroke.bend.swing() : asked && dead && !follows;
    stroke.missing = fails ? stroke.missing + 1 : 0;
    stroke.ticks = 0;
    return stroke_beats <= stroke.missing;
}

/// Whether a robot at rest sinks: from its least depth since it came to rest or, while disarmed, from that of the last
/// seconds. A neutral robot that was pushed under coasts as deep, but slows all the way.
inline bool sinks(Rest& rest, const Limits& limits, const SupervisorInput& input, bool blind, float tick) {
    const Estimate<float>& at = input.at;
    if (!input.still || blind) return rest = {}, false;
    const bool disarmed = input.state == State::disarmed, anew = disarmed && trim_after <= float(rest.ticks) * tick;
    if (rest.ticks == 0 || anew) rest = {at.depth, 0, 0, false, rest.sinks};
    const float way = at.depth - rest.depth;
    const bool down = limits.sink_depth < way && way < trim_coast * at.sink * float(rest.since) * tick;
    rest.sinks = disarmed && (rest.sinks || down);
    if (at.depth < rest.depth || 2 * limits.sink_depth < way) rest.depth = at.depth, rest.since = 0;
    ++rest.ticks, ++rest.since;
    return down || rest.sinks || rest.sank;
}

/// One tick: update the present faults, and those latched since arming.
inline void detect_faults(const Model& model, SupervisorState& memory, const SupervisorInput& input) {
    const Controller<float>& controller = model.pilot.controller;
    const Limits& limits = model.limits;
    const float tick = controller.tick;
    Faults& now = memory.present;
    const auto says = [&](Condition c) { return input.output.status.has(c); };
    bool bend = false, pressure = false, current = false;
    for (int j = 0; j < controller.joints; ++j) bend = bend || input.controller.bend[j].faulty;
    for (int c = 0; c < 2 * controller.joints; ++c) {
        pressure = pressure || input.controller.pressure[c].faulty;
        current = current || input.controller.current[c].faulty;
    }
    const Health<float>& battery = input.controller.voltage;
    const bool voltage_known = battery.seen && !battery.faulty;
    const float supply = input.controller.supply;
    bool stroke = true, pressed = false;
    for (int j = 0; j < controller.joints; ++j) {
        bool& released = memory.released[j];
        if (input.state == State::disarmed) released = false, memory.stroke[j] = {};
        const Status& status = input.output.status;
        const bool stopped = status.has(Condition::hard_stop, 2 * j) || status.has(Condition::hard_stop, 2 * j + 1);
        pressed = pressed || (stopped && !released);
        if (!direct(controller, j) && !stopped)
            released = has_no_stroke(controller, memory.stroke[j], input, j) || released;
        stroke = stroke && !released;
    }
    now.set(Fault::no_stroke, !stroke);
    now.set(Fault::over_pressure, says(Condition::hard_stop) && pressed);
    now.set(Fault::bend_sensor, bend);
    now.set(Fault::pressure_sensor, pressure);
    now.set(Fault::current_sensor, current);
    now.set(Fault::imu, !imu_valid(input.controller));
    now.set(Fault::battery_sensor, battery.faulty);
    if (voltage_known) {  // while the voltage cannot be read, what it was stands
        now.set(Fault::low_battery, lasting(memory.low, supply < controller.voltage_low, limits.voltage_after, tick));
        now.set(Fault::empty_battery, lasting(memory.empty, supply < limits.voltage_empty, limits.voltage_after, tick));
    }
    now.set(Fault::link_lost, limits.link_timeout < input.silence);
    now.set(Fault::link_gone, input.state != State::disarmed && limits.home_timeout < input.silence);
    const float pitch = input.at.facing.z, roll = input.at.tilt, limit = limits.tilt_max;
    const Quaternion<float>& q = input.at.q;
    const bool over = 0.5f < q.x * q.x + q.y * q.y;  // upside down, where both sines are small again
    const bool tilted = input.at.attitude && (over || !(abs(pitch) <= limit && abs(roll) <= limit));
    now.set(Fault::tilt, lasting(memory.tilted, tilted, limits.tilt_after, tick));
    now.set(Fault::leak, recurs(memory.leaking, now.has(Fault::leak), input.leak, limits.leak_after, tick));
    now.set(Fault::overrun, input.overrun);
    now.set(Fault::depth_sensor, lasting(memory.blind, !input.at.depths, sensor_after, tick));
    const bool hull = by_ground(input.state) || input.state == State::surface;
    const bool too_deep = hull && input.at.depths && limits.depth_max < input.at.depth;
    now.set(Fault::too_deep, lasting(memory.deep, too_deep, sensor_after, tick));
    now.set(Fault::black_box, input.lost_records);
    const bool by_hand = input.state == State::manual || input.state == State::gait;
    const bool unknown = now.has(Fault::imu) || now.has(Fault::battery_sensor);
    now.set(Fault::unguarded, recurs(memory.unguarded, false, by_hand && unknown, sensor_after, tick));
    now.set(Fault::no_progress, makes_no_way(memory.way, limits, input, tick));
    now.set(Fault::sinks, sinks(memory.rest, limits, input, now.has(Fault::depth_sensor), tick));
    for (int f = 0; f < faults; ++f)
        if (fault_texts[f].latched && now.has(Fault(f))) memory.latched.set(Fault(f), true);
}

/// All present and latched faults.
inline Faults all_faults(const SupervisorState& memory) { return {memory.present.flags | memory.latched.flags}; }

}  // namespace hypertuna::firmware
