/// Vehicle: the robot's state on board, and all decisions. The radio passes commands on; the vehicle accepts or
/// refuses.
#pragma once

#include "app/vehicle/black_box.hpp"
#include "app/vehicle/mission_check.hpp"
#include "app/vehicle/store.hpp"
#include "app/vehicle/supervisor.hpp"

namespace hypertuna::firmware {

inline constexpr int key_size = 32;
inline constexpr float max_origin_distance =
    2e4f;  // m: a stored mission further from its origin belongs to another water

/// Sectors of the flash memory: two each for the parameters, a mission, the timestamp of signatures and the key; one
/// that bears witness that there was a key.
enum Sector : int { parameter_sector = 0, mission_sector = 2, stamp_sector = 4, key_sector = 6, witness_sector = 8 };
inline constexpr int flash_sectors = 9;
inline constexpr std::uint32_t stamp_layout = 0x73746d02, key_layout = 0x6b657901;
static_assert(piece + int(sizeof(StoredMission)) <= flash_sector && piece + 4 * max_parameters <= flash_sector);

struct StoredKey {
    std::uint32_t present;  // 0: there is none
    std::uint8_t key[key_size];
};

/// Source of the controller's command.
enum class Control : std::uint8_t { manual, gait, mission, count };
struct ControlText {
    const char* name;
    const char* sentence;
};
inline constexpr ControlText control_texts[int(Control::count)] = {
    {"manual", "joystick: MANUAL_CONTROL makes the command, and the tail rests without it"},
    {"gait", "a steady gait of GAIT_SET or HYPERTUNA_CMD_GAIT makes the command"},
    {"mission", "the pilot makes the command from the stored mission"},
};

/// Ascent of a robot that is called home without a mission; a failed ascent is not repeated.
enum class Ascent : std::uint8_t { none, active, failed };

/// The vehicle's public state at the end of the last tick.
struct Snapshot {
    std::uint32_t tick;
    float time;  // s since boot
    PilotReadings<float> readings;
    ControllerOutput<float> output;
    Command<float> command;
    Estimate<float> estimate;
    Mode mode;        // of the pilot
    Reasons reasons;  // of the pilot
    int leg;          // current waypoint
    Control control;
    bool armed;
    Faults faults;
    Answer answer;
    float battery_left;  // fraction of the charge, 0 to 1
    float load;          // CPU time of the last tick as a fraction of the tick
};

/// Duration of a tick's parts [counts of the board's clock].
struct Profile {
    std::uint32_t controller, pilot, whole, radio;  // the radio's part precedes the vehicle's
};

struct Vehicle {
    const Description* robot;
    float value[max_parameters];
    Model model;
    Raw raw;
    PilotState<float> state;
    SupervisorState memory;
    std::uint8_t stored[4 * max_parameters];  // parameters
    StoredMission plan;
    std::uint64_t stamp;  // of signatures: later than every verified timestamp
    StoredKey secret;
    Store store, missions, stamps, keys;
    bool locked, witnessed;  // there was a key, and it cannot be read: no command is accepted; witnesses are complete
    BlackBox box;
    Snapshot now;
    Profile profile;
    Mission<float> mission;
    bool has_mission, way_home;  // on board; uploaded or begun since boot, hence a way home
    Mission<float> up;           // mission of an ascent
    Ascent ascent;
    std::uint32_t ascent_deadline;  // tick at which it has failed
    bool origin_restored;           // the origin is a stored mission's, and there was no fix since boot
    Origin origin;
    Command<float> requested;                    // by the ground
    std::uint32_t ground_contact, requested_at;  // ticks of the ground's last valid frame, of its last command
    bool defaults, watchdog_reset;               // no stored parameters; booted by the watchdog
    std::uint32_t lost;                          // records lost before the last tick
};

inline const Snapshot& snapshot(const Vehicle& vehicle) { return vehicle.now; }

/// Called for every valid frame of the ground station.
inline void on_ground_contact(Vehicle& vehicle) { vehicle.ground_contact = vehicle.now.tick; }

inline const Origin& origin(const Vehicle& vehicle) { return vehicle.origin; }
inline const Mission<float>& mission(const Vehicle& vehicle) { return vehicle.mission; }
inline const Pilot<float>* pilot(const Vehicle& vehicle) { return &vehicle.model.pilot; }
inline const Limits& limits(const Vehicle& vehicle) { return vehicle.model.limits; }

// --- parameters

inline int parameter_count(const Vehicle& vehicle) { return vehicle.robot->parameters; }
inline const ParameterInfo& parameter(const Vehicle& vehicle, int k) { return vehicle.robot->parameter[k]; }
inline float value(const Vehicle& vehicle, int k) { return vehicle.value[k]; }

/// Set and store a parameter. Only while disarmed.
inline Refusal set_parameter(Vehicle& vehicle, int k, float to) {
    const Description& robot = *vehicle.robot;
    if (k < 0 || k >= robot.parameters) return Refusal::unknown;
    if (vehicle.now.armed) return Refusal::armed;
    const ParameterInfo& info = robot.parameter[k];
    if (!in_range(info, to)) return Refusal::out_of_range;
    if (to == vehicle.value[k] && !vehicle.store.failed) return Refusal::none;  // spare the memory
    const float before = vehicle.value[k];
    vehicle.value[k] = to;
    configure(vehicle.model, robot, vehicle.value, info.field);
    if (!consistent(vehicle.model) || (vehicle.model.limits.sign == 1.0f && vehicle.secret.present == 0)) {
        vehicle.value[k] = before;
        configure(vehicle.model, robot, vehicle.value, info.field);
        return Refusal::inconsistent;
    }
    std::memcpy(vehicle.stored + 4 * k, &to, 4);
    begin_write(vehicle.store);
    return Refusal::none;
}

/// Key that signs commands; nullptr if there is none.
inline const std::uint8_t* key(const Vehicle& vehicle) {
    return vehicle.secret.present != 0 ? vehicle.secret.key : nullptr;
}
/// Store a key; zeros delete it.
inline Refusal set_key(Vehicle& vehicle, const std::uint8_t (&to)[key_size]) {
    if (vehicle.now.armed) return Refusal::armed;
    vehicle.secret.present = 0;
    for (std::uint8_t byte : to) vehicle.secret.present |= byte != 0;
    std::memcpy(vehicle.secret.key, to, key_size);
    begin_write(vehicle.keys);
    return Refusal::none;
}

// --- commands

/// Command that brings the tail to rest and levels the fins.
inline Command<float> rest() {
    Command<float> command{};
    command.fresh = command.armed = true;
    return command;
}

/// Where the robot believes to be.
inline Place here(const Vehicle& vehicle) { return {vehicle.now.estimate.x, vehicle.now.estimate.y}; }

/// Restart guidance on a mission, from the robot's position.
inline void begin_mission(Vehicle& vehicle, Mission<float>& mission) {
    mission.start = here(vehicle);
    vehicle.state.guidance = init(vehicle.model.pilot.guidance, mission);
    vehicle.state.wait = 0;
}

/// Collect all faults, and the response to them.
inline void evaluate_faults(Vehicle& vehicle) {
    Snapshot& now = vehicle.now;
    now.faults = all_faults(vehicle.memory);
    now.faults.set(Fault::watchdog, vehicle.watchdog_reset);
    now.faults.set(Fault::defaults, vehicle.defaults);
    now.faults.set(Fault::memory,
                   vehicle.store.failed || vehicle.missions.failed || vehicle.stamps.failed || vehicle.keys.failed);
    now.faults.set(Fault::key_lost, vehicle.locked);
    now.answer = answer_to(now.faults);
}

/// Ascend here, by a mission without waypoints whose home is everywhere: guidance circles slowly with its fins up, and
/// handles the loss of IMU, depth or a fin.
inline void begin_ascent(Vehicle& vehicle) {
    Mission<float>& up = vehicle.up;
    up = {};
    up.home = here(vehicle);
    up.home_radius = up.depth_max = 1e4f, up.home_speed = vehicle.model.pilot.guidance.slow;
    begin_mission(vehicle, up);
    vehicle.state.guidance.rising = false;  // do not wait for a fix
    vehicle.state.guidance.reasons.set(Reason::recalled);
    const Guidance<float>& guidance = vehicle.model.pilot.guidance;
    const float limit = clamp(time_home(guidance, vehicle.now.estimate, up), 0.0f, 3600.0f);
    vehicle.ascent_deadline = vehicle.now.tick + std::uint32_t(limit / vehicle.model.pilot.controller.tick);
}

/// Arm or disarm. Disarming is never refused.
inline Refusal arm(Vehicle& vehicle, bool on) {
    if (!on) {
        vehicle.now.armed = false;
        vehicle.now.control = Control::gait;
        return Refusal::none;
    }
    if (vehicle.now.armed) return Refusal::none;
    if (vehicle.locked || forbids_arming(vehicle.memory.present)) return Refusal::faulty;
    for (const Store* store : {&vehicle.store, &vehicle.missions, &vehicle.stamps, &vehicle.keys})
        if (!settled(*store)) return Refusal::busy;
    if (!vehicle.now.estimate.attitude) return Refusal::not_ready;
    const bool placed = vehicle.origin.known && !vehicle.origin_restored;
    if (vehicle.has_mission && placed && !holds(vehicle.mission, here(vehicle))) return Refusal::robot_outside;
    vehicle.memory.latched = {};
    vehicle.memory.present.set(Fault::link_gone, false);  // the ground is in contact: it arms
    vehicle.watchdog_reset = false;
    evaluate_faults(vehicle);
    vehicle.now.armed = true;
    vehicle.now.control = Control::gait;
    vehicle.ascent = Ascent::none;
    vehicle.requested = rest();
    vehicle.requested_at = vehicle.ground_contact = vehicle.now.tick;
    return Refusal::none;
}

/// Take the command from another source, at rest until it makes one.
inline void take_control(Vehicle& vehicle, Control control) {
    if (control == Control::mission) {
        if (vehicle.now.control != Control::mission) begin_mission(vehicle, vehicle.mission);
        vehicle.way_home = true;
    }
    vehicle.requested = rest();
    vehicle.requested_at = vehicle.now.tick;
    vehicle.now.control = control;
}

/// Change the source of the command on the ground's order: to the mission, or to the ground's own gaits.
inline Refusal set_control(Vehicle& vehicle, Control control) {
    if (control >= Control::count) return Refusal::unknown;
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (control != Control::mission && Answer::home <= vehicle.now.answer) return Refusal::faulty;
    if (control == Control::mission) {
        if (!vehicle.has_mission) return Refusal::no_mission;
        const Refusal refusal = check_start(vehicle.mission, here(vehicle));
        if (vehicle.now.control != Control::mission && refusal != Refusal::none) return refusal;
    }
    take_control(vehicle, control);
    return Refusal::none;
}

/// Whether a command is within the controller's limits.
inline bool within(const Controller<float>& model, const Command<float>& command) {
    const auto in = [](float low, float x, float high) { return low <= x && x <= high; };
    bool good = in(0, command.frequency, model.frequency_max);
    for (int j = 0; j < model.joints; ++j) {
        const float limit = model.joint[j].amplitude, turn = float(2 * pi);
        good = good && in(0, command.amplitude[j], limit) && in(-turn, command.phase[j], turn) &&
               in(-limit, command.bias[j], limit);
    }
    for (int k = 0; k < 2; ++k) good = good && in(-model.fin_max, command.fin[k], model.fin_max);
    return good;
}

/// Accept a gait of the ground, unless the robot is called home or must rest.
inline Refusal set_command(Vehicle& vehicle, const Command<float>& command, Control control) {
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (Answer::home <= vehicle.now.answer) return Refusal::faulty;
    if (!within(vehicle.model.pilot.controller, command)) return Refusal::out_of_range;
    vehicle.requested = command;
    vehicle.requested.armed = true;
    vehicle.requested_at = vehicle.now.tick;
    vehicle.now.control = control;
    return Refusal::none;
}

/// A gait that goes on while the ground is in contact.
inline Refusal set_gait(Vehicle& vehicle, const Command<float>& command) {
    return set_command(vehicle, command, Control::gait);
}

/// A gait of the joystick, which ends without the next in time.
inline Refusal set_manual(Vehicle& vehicle, const Command<float>& command) {
    return set_command(vehicle, command, Control::manual);
}

/// Clamp a command to the controller's limits.
inline void clamp_command(const Controller<float>& model, Command<float>& command) {
    command.frequency = min(command.frequency, model.frequency_max);
    for (int j = 0; j < model.joints; ++j) {
        const float limit = model.joint[j].amplitude;
        command.amplitude[j] = min(command.amplitude[j], limit);
        command.bias[j] = clamp(command.bias[j], -limit, limit);
    }
    for (float& fin : command.fin) fin = clamp(fin, -model.fin_max, model.fin_max);
}

/// A gait of the joystick by the gait table: ahead from 0 to 1 of the top speed, turn to port and climb from -1 to 1,
/// clamped to the limits. With ahead = 0 the tail straightens instead of stopping in mid-beat.
inline Refusal set_manual(Vehicle& vehicle, float ahead, float turn, float climb) {
    if (!(0 <= ahead && ahead <= 1 && abs(turn) <= 1 && abs(climb) <= 1)) return Refusal::out_of_range;
    const Steering<float>& steering = vehicle.model.pilot.guidance.steering;
    Command<float> command = rest();
    const float top = steering.table.speed[steering.table.gaits - 1];
    beat_into(steering, command, ahead * top, -turn);
    for (int j = 0; j < max_joints && ahead == 0.0f; ++j) command.amplitude[j] = 0.0f;
    command.fin[0] = command.fin[1] = climb * steering.fin_max;
    clamp_command(vehicle.model.pilot.controller, command);
    return set_manual(vehicle, command);
}

/// Store the mission on board and its origin. It is written while disarmed.
inline void store_mission(Vehicle& vehicle) {
    const Origin& origin = vehicle.origin;
    vehicle.plan.has_origin = origin.known, vehicle.plan.latitude = origin.latitude;
    vehicle.plan.longitude = origin.longitude;
    begin_write(vehicle.missions);
}

/// Copy a mission on board; an invalid mission is refused as a whole.
inline Refusal set_mission(Vehicle& vehicle, const Mission<float>& mission) {
    if (vehicle.now.armed && vehicle.now.control == Control::mission) return Refusal::busy;
    if (mission.waypoints > max_waypoints || mission.corners > max_corners) return Refusal::too_many;
    if (!fits(mission.waypoints, mission.corners) || !is_valid(mission)) return Refusal::out_of_range;
    const Refusal refusal = check_mission(mission, vehicle.model.pilot.estimator.depth_high);
    if (refusal != Refusal::none) return refusal;
    pack_mission(vehicle.plan, mission);
    vehicle.mission = mission_of(vehicle.plan);
    vehicle.has_mission = vehicle.way_home = true, vehicle.ascent = Ascent::none;
    store_mission(vehicle);
    return Refusal::none;
}

/// Delete the mission on board and the stored one.
inline Refusal clear_mission(Vehicle& vehicle) {
    if (vehicle.now.armed && vehicle.now.control == Control::mission) return Refusal::busy;
    if (!vehicle.has_mission) return Refusal::none;
    vehicle.has_mission = false, vehicle.mission = {};
    std::memset(static_cast<void*>(&vehicle.plan), 0, sizeof(vehicle.plan));
    begin_write(vehicle.missions);
    return Refusal::none;
}

/// Restart the position estimate at a position.
inline void reset_position(Vehicle& vehicle, float x, float y) {
    const float start[2] = {x, y};
    vehicle.state.estimator.way = init(vehicle.model.pilot.estimator, start).way;
    vehicle.origin_restored = false;
}

/// Set the origin of local coordinates, and the robot's position; without it the first fix is the origin. An origin
/// that would move the mission on board is refused.
inline Refusal set_origin(Vehicle& vehicle, std::int32_t latitude, std::int32_t longitude, float x = 0, float y = 0) {
    if (vehicle.now.armed) return Refusal::armed;
    if (!is_place(latitude, longitude)) return Refusal::out_of_range;
    if (!(abs(x) < 1e5f && abs(y) < 1e5f)) return Refusal::out_of_range;
    const Origin& before = vehicle.origin;
    const bool same = before.known && before.latitude == latitude && before.longitude == longitude;
    if (vehicle.has_mission && before.known && !same) return Refusal::elsewhere;
    vehicle.origin = origin_at(latitude, longitude);
    if (vehicle.has_mission && !same) store_mission(vehicle);
    reset_position(vehicle, x, y);
    return Refusal::none;
}

/// The first fix since boot becomes the origin, unless a stored mission has one. If that origin is too far away, the
/// mission is dropped.
inline void on_first_fix(Vehicle& vehicle, const std::int32_t (&fix)[2]) {
    if (vehicle.origin_restored) {
        const Corner<float> at = local(vehicle.origin, fix[0], fix[1]);
        const bool near = abs(at.x) < max_origin_distance && abs(at.y) < max_origin_distance;
        reset_position(vehicle, near ? at.x : 0.0f, near ? at.y : 0.0f);
        if (near) return;
        vehicle.has_mission = vehicle.origin.known = false, vehicle.mission = {};
        if (vehicle.now.control == Control::mission) vehicle.now.control = Control::gait;  // at rest
    }
    if (vehicle.origin.known) return;
    vehicle.origin = origin_at(fix[0], fix[1]);
    if (vehicle.has_mission) store_mission(vehicle);
}

}  // namespace hypertuna::firmware
