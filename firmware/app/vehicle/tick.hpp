/// Tick: the vehicle's loop at 100 Hz.
///
/// counts -> readings -> estimate -> command of mission, gait or joystick -> controller -> pulses; then the
/// supervisor detects faults, and selects the response of the next tick.
#pragma once

#include <new>
#include <string_view>

#include "app/vehicle/controller.hpp"
#include "app/vehicle/failsafe.hpp"
#include "app/vehicle/record.hpp"

namespace hypertuna::firmware {

inline constexpr float late_tick = 1.5f;           // ticks since the start of the last one from which a tick is late
inline constexpr std::uint32_t late_report = 100;  // ticks for which a late tick is reported
inline constexpr int max_steps = 5;                // steps of control in a tick
inline constexpr float still_speed = 0.15f;        // m/s through the water: a slower robot has come to rest

/// Data that survives a reset without loss of power, in a word: whether the robot was armed, and the zero of its depth
/// [m].
struct Kept {
    bool valid, armed;
    float zero;
};
inline constexpr std::uint32_t kept_mark = 0x5a000000, kept_armed = 1 << 16, kept_center = 1 << 15;
inline std::uint32_t pack(bool armed, float zero) {
    return kept_mark | (armed ? kept_armed : 0) |
           std::uint32_t(int(kept_center) + int(1e3f * clamp(zero, -30.0f, 30.0f)));
}
inline Kept unpack(std::uint32_t word) {
    return {(word & 0xff000000) == kept_mark, (word & kept_armed) != 0,
            1e-3f * float(int(word & 0xffff) - int(kept_center))};
}

/// Restore the stored parameters; false if one is out of range or conflicts with another.
[[gnu::cold]] inline bool restore(Vehicle& vehicle) {
    const Description& robot = *vehicle.robot;
    std::memcpy(vehicle.value, vehicle.stored, std::size_t(4 * robot.parameters));
    for (int k = 0; k < robot.parameters; ++k)
        if (!in_range(robot.parameter[k], vehicle.value[k])) return false;
    configure(vehicle.model, robot, vehicle.value);
    return consistent(vehicle.model);
}

/// Restore the stored mission and its origin, if it is valid.
[[gnu::cold]] inline void restore_mission(Vehicle& vehicle) {
    const StoredMission& plan = vehicle.plan;
    const Mission<float> mission = mission_of(plan);
    if (!fits(plan.waypoints, plan.corners) || !is_valid(plan.form, plan.waypoints, plan.corners) ||
        check_ranges(mission) != Refusal::none || !is_place(plan.latitude, plan.longitude))
        return forget_mission(vehicle);
    adopt_plan(vehicle);
    if (plan.has_origin == 0) return;
    vehicle.origin = origin_at(plan.latitude, plan.longitude);
    vehicle.unplaced = true;
}

/// Use the parameters of the description. A robot with a key keeps signing.
[[gnu::cold]] inline void use_defaults(Vehicle& vehicle) {
    const Description& robot = *vehicle.robot;
    for (int k = 0; k < robot.parameters; ++k) {
        const ParameterInfo& info = robot.parameter[k];
        vehicle.value[k] = key(vehicle) != nullptr && std::string_view(info.name) == "sign" ? 1.0f : info.standard;
    }
    std::memcpy(vehicle.stored, vehicle.value, std::size_t(4 * robot.parameters));
    configure(vehicle.model, robot, vehicle.value);
}

/// Read the key. A key that was stored and cannot be read locks the robot, until somebody deletes it with the board in
/// hand.
template <Board B>
[[gnu::cold]] void open_key(Vehicle& vehicle, B& board) {
    vehicle.keys = store_at(key_sector, int(sizeof(StoredKey)), key_layout);
    if (board.recovers())
        for (int sector : {key_sector + 0, key_sector + 1, witness_sector + 0}) board.erase(sector);
    const bool valid = open(vehicle.keys, reinterpret_cast<std::uint8_t*>(&vehicle.secret), board);
    const int copies = count_witnesses(board, witness_sector);
    vehicle.locked = !valid && copies > 0, vehicle.witnessed = copies == witnesses;
}

/// Boot: disarmed, at rest, with the stored parameters or else those of the description.
template <Board B>
[[gnu::cold]] void boot(Vehicle& vehicle, const Description& robot, B& board) {
    static_assert(std::is_trivially_copyable_v<Vehicle> && std::is_trivially_default_constructible_v<Vehicle>);
    std::memset(&vehicle, 0, sizeof(vehicle));  // a temporary would not fit onto the stack
    vehicle.robot = &robot;
    vehicle.store = store_at(parameter_sector, 4 * robot.parameters, robot.layout);
    vehicle.missions = store_at(mission_sector, int(sizeof(StoredMission)), mission_layout);
    vehicle.stamps = store_at(stamp_sector, 8, stamp_layout);
    open_key(vehicle, board);
    vehicle.defaults = !open(vehicle.store, vehicle.stored, board) || !restore(vehicle);
    if (vehicle.defaults) use_defaults(vehicle);  // an invalid set is ignored as a whole
    open(vehicle.stamps, reinterpret_cast<std::uint8_t*>(&vehicle.stamp), board);
    vehicle.mission.home_radius = vehicle.mission.home_speed = 1;
    if (open(vehicle.missions, reinterpret_cast<std::uint8_t*>(&vehicle.plan), board)) restore_mission(vehicle);
    new (&vehicle.state) PilotState<float>(init(vehicle.model.pilot, vehicle.mission));  // in place, as above
    vehicle.watchdog_reset = board.watchdog_reset();
    const Kept kept = unpack(board.kept());
    vehicle.was_armed = kept.valid && kept.armed;
    EstimatorState<float>& estimator = vehicle.state.estimator;
    vehicle.surfaces = store_at(surface_sector, 4, surface_layout);
    if (open(vehicle.surfaces, reinterpret_cast<std::uint8_t*>(&vehicle.surface), board))
        expect_surface(vehicle.model.pilot.estimator, estimator, vehicle.surface);
    if (vehicle.was_armed || (kept.valid && vehicle.watchdog_reset)) keep_zero(estimator, kept.zero);
    vehicle.started = board.clock();
    Record record(vehicle.box, Kind::robot);
    record.put(record_layout), record.put(robot.layout), record.put(std::uint32_t(robot.joints));
    record.end();
}

/// Let fins only lift below the depth limit of the hull, shortly above it, and where the depth sensor failed.
inline void limit_fins(const Vehicle& vehicle, Command<float>& command) {
    const Snapshot& now = vehicle.now;
    const bool known = !now.faults.has(Fault::depth_sensor);
    if (known && now.estimate.depth < vehicle.model.limits.depth_max - depth_error_max) return;
    for (float& fin : command.fin) fin = max(0.0f, fin);
}

/// Return the command of a state; nullptr where guidance makes it.
inline const Command<float>* choose_command(Vehicle& vehicle, Command<float>& made) {
    const Snapshot& now = vehicle.now;
    const float since = float(now.tick - vehicle.requested_at) * vehicle.model.pilot.controller.tick;
    made = rest();
    made.armed = now.armed();
    if (is_guided(now.state)) return nullptr;
    switch (now.state) {
        case State::manual:  // the sticks must repeat their command
            if (vehicle.model.limits.manual_timeout < since) return &made;
            [[fallthrough]];
        case State::gait:
            made = vehicle.requested, made.fresh = true;
            limit_fins(vehicle, made);
            return &made;
        default:
            return &made;
    }
}

/// Write the tick's record into the black box.
inline void record_tick(Vehicle& vehicle) {
    Record record(vehicle.box, Kind::tick);
    visit_record(vehicle.now, vehicle.model.pilot.controller.joints,
                 [&](const char*, auto... values) { record.put(values...); });
    record.end();
}

/// Whether silence of the ground station counts: under water the pilot on board does not expect to hear it, unless the
/// mission does.
inline bool could_receive(const Vehicle& vehicle) {
    const Estimate<float>& at = vehicle.now.estimate;
    const bool by_pilot = is_guided(vehicle.now.state) || vehicle.now.state == State::held;
    return !by_pilot || vehicle.mission.silence_below || !at.depths || at.depth < radio_depth;
}

/// Whether the tail rests and the robot no longer moves through the water.
inline bool rests(const Vehicle& vehicle) {
    const Command<float>& command = vehicle.now.command;
    bool still = vehicle.now.estimate.speed < still_speed;
    for (int j = 0; j < vehicle.model.pilot.controller.joints; ++j) still = still && command.amplitude[j] == 0.0f;
    return still;
}

/// Whether the beat is meant to move the robot: on a course of the pilot, or by order of the ground.
inline bool makes_way(const Vehicle& vehicle) {
    const Snapshot& now = vehicle.now;
    const Mode mode = vehicle.state.guidance.mode;
    const bool piloted = is_guided(now.state) && (mode == Mode::transit || mode == Mode::home);
    return now.estimate.attitude && (piloted || now.state == State::manual || now.state == State::gait);
}

/// Leg that the pilot is on, max_waypoints for the way home; -1 without a leg, and where the robot waits at a waypoint.
inline int leg_of(const Vehicle& vehicle) {
    const GuidanceState<float>& guidance = vehicle.state.guidance;
    if (vehicle.now.state == State::held) return vehicle.memory.way.leg;
    if (!is_guided(vehicle.now.state) || 0 < guidance.held || 0 < guidance.arriving) return -1;
    return guidance.mode == Mode::home ? max_waypoints : guidance.leg;
}

/// Detect faults, evaluate the response, estimate the charge.
inline void supervise(Vehicle& vehicle) {
    Snapshot& now = vehicle.now;
    const float tick = vehicle.model.pilot.controller.tick;
    vehicle.silence += could_receive(vehicle);
    const float silence = float(vehicle.silence) * tick;
    const bool late = 0 < std::int32_t(vehicle.late_until - now.tick);
    const bool still = rests(vehicle), driven = !still && makes_way(vehicle);
    const SupervisorInput input{
        vehicle.state.controller,         now.output, now.estimate, now.readings, vehicle.raw.leak, late,
        vehicle.box.lost != vehicle.lost, still,      driven,       now.state,    leg_of(vehicle),  silence};
    vehicle.lost = vehicle.box.lost;
    detect_faults(vehicle.model, vehicle.memory, input);
    for (int j = 0; j < vehicle.model.pilot.controller.joints; ++j)
        if (vehicle.memory.released[j]) vehicle.state.controller.circuit[2 * j].stopped = true;
    evaluate_faults(vehicle);
    const Guidance<float>& guidance = vehicle.model.pilot.guidance;
    const float above = vehicle.state.controller.supply + guidance.battery_drop - guidance.battery_empty;
    now.battery_left = clamp(above / guidance.battery_span, 0.0f, 1.0f);
}

/// One step of control: estimate, state, command, controller.
template <Board B>
void control(Vehicle& vehicle, B& board) {
    Snapshot& now = vehicle.now;
    PilotState<float>& state = vehicle.state;
    const Pilot<float>& pilot = vehicle.model.pilot;
    const std::uint32_t start = board.clock();
    const Place before = here(vehicle);
    const bool anew = may_begin_anew(vehicle);
    now.estimate = perceive(pilot, state, now.readings, vehicle.mission.declination);
    follow_fixes(vehicle, before, anew);
    respond(vehicle);
    Command<float> made;
    const Command<float>* command = choose_command(vehicle, made);
    const bool decision = due(pilot, state);
    if (command == nullptr && decision) decide(pilot, state, now.estimate, flown(vehicle));
    if (command != nullptr) state.command = *command;
    const std::uint32_t middle = board.clock();
    run_controller(pilot, state, now.estimate, now.readings.robot, now.output);
    vehicle.profile.controller = board.clock() - middle;
    vehicle.profile.pilot = middle - start;
    now.command = state.command;
    now.reasons = state.guidance.reasons;
    if (command == nullptr && decision) follow_pilot(vehicle);
    const bool guided = command == nullptr || now.state == State::paused, over = has_ended(state.guidance.mode);
    now.mode = guided || over ? state.guidance.mode : Mode::idle;
    now.leg = (guided || over) && !vehicle.on_detour ? state.guidance.leg : vehicle.leg;
}

/// Convert the samples of a tick to readings.
inline void sense(Vehicle& vehicle) {
    vehicle.raw.fixed = vehicle.raw.fixed && is_place(vehicle.raw.fix[0], vehicle.raw.fix[1]);
    if (vehicle.raw.fixed)
        vehicle.fix = {{vehicle.raw.fix[0], vehicle.raw.fix[1]},
                       vehicle.raw.accuracy,
                       vehicle.now.tick,
                       vehicle.raw.satellites,
                       true};
    if (vehicle.raw.fixed && !vehicle.fixed) on_first_fix(vehicle, vehicle.raw.fix);
    vehicle.now.readings =
        convert(vehicle.model.calibration, vehicle.model.pilot.controller.joints, vehicle.raw, vehicle.origin);
}

/// Number of control steps in this tick: as many ticks as the clock has counted since the last one, so that beat, dead
/// reckoning and time-outs keep their time when ticks come late; at least one, and at most max_steps. Further ones are
/// lost. A tick that is late only because of an erasure, which is made while disarmed, is not reported.
template <Board B>
int steps_due(Vehicle& vehicle, B& board) {
    const std::uint32_t start = board.clock();
    const float elapsed = float(start - vehicle.started) / float(board.per_tick());
    vehicle.started = start;
    if (vehicle.now.tick == 0) return 1;  // the time since the last one is that of the boot
    if (late_tick < elapsed - float(vehicle.writing) / float(board.per_tick()))
        vehicle.late_until = vehicle.now.tick + late_report;
    vehicle.steps_behind += min(elapsed, float(2 * max_steps));
    const int whole = int(vehicle.steps_behind + 0.5f), steps = whole < 1 ? 1 : whole < max_steps ? whole : max_steps;
    vehicle.steps_behind -= float(steps);
    if (0.5f < abs(vehicle.steps_behind)) vehicle.steps_behind = 0.0f;
    return steps;
}

/// Send the controller's pulses with each servo's trim, clamped; none once a disarmed tail is at rest.
template <Board B>
void send_pulses(const Vehicle& vehicle, B& board) {
    const Controller<float>& controller = vehicle.model.pilot.controller;
    const int servos = servos_of(controller.joints);
    float pulse[max_servos] = {};
    bool moving = vehicle.now.armed();
    for (int k = 0; k < servos; ++k) {
        moving = moving || 1e-3f < abs(vehicle.now.output.target[k]);
    }
    for (int k = 0; k < servos && moving; ++k)
        pulse[k] = clamp(vehicle.now.output.pulse[k] + vehicle.model.calibration.trim[k], controller.pulse_min,
                         controller.pulse_max);
    board.drive(pulse, servos);
}

/// Do one operation of the flash memory, which stops interrupts: none while armed; all wait until then. The key comes
/// first, and its witnesses once it is valid.
template <Board B>
void write_stores(Vehicle& vehicle, B& board) {
    if (vehicle.now.armed()) return;
    remember_surface(vehicle);
    const auto bytes = [](auto& from) { return reinterpret_cast<const std::uint8_t*>(&from); };
    if (!settled(vehicle.keys)) return write_some(vehicle.keys, bytes(vehicle.secret), board);
    if (0 <= vehicle.keys.kept && !vehicle.witnessed) {
        vehicle.witnessed = true, vehicle.keys.failed = !bear_witness(board, witness_sector);
        return;
    }
    if (!settled(vehicle.store)) return write_some(vehicle.store, vehicle.stored, board);
    if (!settled(vehicle.stamps)) return write_some(vehicle.stamps, bytes(vehicle.stamp), board);
    if (!settled(vehicle.surfaces)) return write_some(vehicle.surfaces, bytes(vehicle.surface), board);
    write_some(vehicle.missions, bytes(vehicle.plan), board);
}

/// One tick, after the radio's part.
template <Board B>
void tick(Vehicle& vehicle, B& board) {
    const int steps = steps_due(vehicle, board);
    const std::uint32_t start = vehicle.started;
    vehicle.raw = {};
    board.read(vehicle.raw);
    sense(vehicle);
    for (int k = 0; k < steps; ++k) {
        if (k > 0) ++vehicle.now.tick, vehicle.now.readings.fixed = false;
        control(vehicle, board);
        supervise(vehicle);
    }
    send_pulses(vehicle, board);
    record_tick(vehicle);
    flush(vehicle.box, board);
    const std::uint32_t write = board.clock();
    write_stores(vehicle, board);
    vehicle.writing = board.clock() - write;
    board.keep(pack(vehicle.now.armed(), vehicle.state.estimator.zero));
    ++vehicle.now.tick;
    vehicle.now.time = float(vehicle.now.tick) * vehicle.model.pilot.controller.tick;
    vehicle.profile.whole = board.clock() - start;
    vehicle.now.load = float(vehicle.profile.whole + vehicle.profile.radio) / float(board.per_tick());
    board.feed();
}

}  // namespace hypertuna::firmware
