/// Supervisor: detects the faults that controller and pilot cannot know of.
#pragma once

#include "app/vehicle/faults.hpp"
#include "app/vehicle/parameters.hpp"
#include "app/vehicle/states.hpp"

namespace hypertuna::firmware {

/// Lowest and highest value, within a beat for example.
struct Extent {
    float low, high;
    void add(float x, bool first) { low = first ? x : min(low, x), high = first ? x : max(high, x); }
    float swing() const { return high - low; }
    bool has(float x) const { return low < x && x < high; }
};

inline constexpr float sensor_after = 1.0f;  // s until a depth, or its absence, is believed
inline constexpr float trim_after =
    10.0f;  // s after which a disarmed robot's sinking is judged anew: hands may move it
inline constexpr float trim_coast =
    1.2f;  // largest mean rate of a sinking robot over its present rate; one that coasts down slows by more
inline constexpr float stroke_bend = 0.65f;      // part of the swing asked; a joint that bends less does not follow
inline constexpr float stroke_pressure = 0.25f;  // part of the working pressure: a stroke brings more
inline constexpr float stroke_bias = 0.25f;      // part of the amplitude; with more bias, lost oil is not judged
inline constexpr int stroke_beats = 3;           // beats in a row in which a joint does not follow
inline constexpr float stroke_empty =
    0.5f;  // part of the fill pressure: with oil, each side's pressure passes the fill pressure in each beat
inline constexpr float turn_own = 6, turn_other = 3.5f;  // a joint's yield to pressure over that of hoses and oil: what
                                                         // a servo displaces for its own side and the other
inline constexpr float turn_least = 0.2f;   // part of the other side's spread; with a bias, a servo that has to turn by
                                            // less shows little
inline constexpr float turn_stands = 0.3f;  // part of the angle sent; a servo that turns by less stands
inline constexpr Extent turn_bend{0.2f, 1.25f};  // part of the swing asked: with less the bend sensor shows nothing,
                                                 // with more the water moves the joint
inline constexpr Extent turn_pressure{0.02f, 0.5f};  // part of the working pressure by which a side swings: more than
                                                     // noise, and less than an oil that ebbs and flows
inline constexpr float snag_reach =
    0.25f;  // part of snag_distance: a robot that stays within this of a fix makes no way
inline constexpr float snag_errors = 2.0f;  // standard deviations of a fix that `snag_reach` is at least
inline constexpr float snag_straight =
    0.7f;  // least part of the way swum that is straight, on a course; a robot that circles has less
inline constexpr float snag_circles =
    2.0f;  // times snag_distance: after such a distance on one leg the robot is not circling
inline constexpr float radio_depth = 0.3f;  // m, depth of the nose from which water over the antenna stops the radio

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

/// Sums over a beat of the angles to which a servo was sent, and of those that bend and pressures show.
struct Turn {
    float sent, shown, square, product;
    void add(float at, float seen) { sent += at, shown += seen, square += at * at, product += at * seen; }
    /// Variance of the angles sent, times the square of the ticks.
    float spread(float ticks) const { return ticks * square - sent * sent; }
    /// Slope of the line that fits the angles shown over those sent: whether it is below a number.
    bool less(float slope, float ticks) const { return ticks * product - sent * shown < slope * spread(ticks); }
};

/// What was asked of a joint and what its sensors showed within a beat.
struct Stroke {
    Extent asked, bend, pressure[2];  // rad, Pa
    Turn turn[2];
    bool explained;      // whether bend and pressures contradict each other, for which the controller blames a sensor
    int ticks, missing;  // ticks of the beat; beats in a row in which the joint did not follow
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
    return seconds - 0.5f * tick < held || (was && 0.0f < held);  // a sum of ticks is rounded
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

/// Angle of the servo of a joint's side from neutral, as bend and pressures show it: the one that holds the bend at
/// rest, and the oil by which both sides' pressures differ from those at rest. Water moves the joint, but no oil.
inline float shown_angle(const Controller<float>& model, const Readings<float>& readings, int j, int side) {
    const int c = 2 * j + side, other = c + 1 - 2 * side;
    const float bend = side == 0 ? readings.bend[j] : -readings.bend[j];
    const float* term = model.map[c].term;
    const auto off = [&](int at, float to) { return readings.pressure[at] - held(model.circuit[at], to); };
    return (term[0] + term[1] * bend) * bend +
           model.circuit[c].compliance * (turn_own * off(c, bend) + turn_other * off(other, -bend));
}

/// Whether a servo of a joint stood in a beat: the angle that bend and pressures show does not follow the angle sent.
inline bool a_servo_stands(const Controller<float>& model, const Stroke& stroke, int j) {
    const float ticks = float(stroke.ticks), work = model.pressure_work - model.circuit[2 * j].fill;
    const auto stands = [&](int side) {
        const Turn &turn = stroke.turn[side], &other = stroke.turn[1 - side];
        return turn_pressure.has(stroke.pressure[side].swing() / work) && turn.less(turn_stands, ticks) &&
               turn_least * other.spread(ticks) < turn.spread(ticks);
    };
    return stands(0) || stands(1);
}

/// Whether a joint with oil does not follow for some beats: oil is lost, or a servo stands.
///
/// Without oil the joint bends by much less than its pumps were sent to, which is what the limits leave of what was
/// asked, and a side's pressure does not rise. That contradicts the model of bend and pressure, so the sensors of both
/// may count as faulty first. If the readings of both go on, and one side's pressure stays far below the fill pressure,
/// oil is missing, and not two sensors.
inline bool has_no_stroke(const Controller<float>& model, Stroke& stroke, const SupervisorInput& input, int j) {
    const ControllerState<float>& state = input.controller;
    const Readings<float>& readings = input.readings.robot;
    const bool first = stroke.ticks++ == 0;
    if (first) stroke.turn[0] = stroke.turn[1] = {}, stroke.explained = false;
    stroke.asked.add(state.bend_sent[j], first), stroke.bend.add(readings.bend[j], first);
    const float asked = stroke.asked.swing(), bend = stroke.bend.swing(), reach = model.joint[j].reach;
    bool dry = false, empty = false, goes_on = true;
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        const hypertuna::SupervisorState<float>& circuit = state.circuit[c];
        Extent& pressure = stroke.pressure[side];
        pressure.add(readings.pressure[c], first);
        stroke.turn[side].add(circuit.servo.value, shown_angle(model, readings, j, side));
        stroke.explained = stroke.explained || circuit.bent || circuit.wrong;
        const float fill = model.circuit[c].fill, work = model.pressure_work - fill;
        const float rise = held(model.circuit[c], side == 0 ? stroke.asked.high : -stroke.asked.low) - fill;
        dry = dry || pressure.high < fill + stroke_pressure * min(work, 2 * rise);
        empty = empty || pressure.high < stroke_empty * fill;
        goes_on = goes_on && 0 < pressure.swing();
    }
    if (!state.posture[j].ended) return stroke_beats <= stroke.missing;
    // A bias takes up a part of the joint's reach, and holds one side's pressure.
    const bool even = abs(state.bias[j].value) < stroke_bias * state.amplitude[j].value;
    const bool bend_lost = state.bend[j].faulty, pressure_lost = blind(state, j),
               trusted = !bend_lost && !pressure_lost;
    const bool swings = 2 * model.posture.amplitude_min < asked, follows = stroke_bend * asked < bend;
    const bool lost =
        trusted ? swings && even && dry && !follows : bend_lost && pressure_lost && empty && goes_on && 0 < bend;
    const bool within = turn_bend.has(bend / asked) && -reach < stroke.bend.low && stroke.bend.high < reach;
    const bool judged = trusted || (stroke.explained && !follows);
    const bool fails = lost || (swings && within && judged && a_servo_stands(model, stroke, j));
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
