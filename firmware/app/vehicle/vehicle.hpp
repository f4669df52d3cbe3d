/// Vehicle: all of the robot's state on board, and everything that decides. The link asks, the vehicle answers.
#pragma once

#include "app/vehicle/black_box.hpp"
#include "app/vehicle/kept_mission.hpp"
#include "app/vehicle/refusal.hpp"
#include "app/vehicle/store.hpp"
#include "app/vehicle/supervisor.hpp"

namespace hypertuna::firmware {

inline constexpr int key_size = 32;
inline constexpr float far_away = 2e4f;  // m from its origin, where a kept mission is of another water

/// What lasts, and where: parameters with the key, a mission, the stamp of signatures; two slots of each.
inline constexpr int most_kept = 4 * most_parameters + 4 + key_size;
inline constexpr int missions_at = 2 * (slot_head + most_kept);
inline constexpr int stamps_at = missions_at + 2 * (slot_head + int(sizeof(KeptMission)));
inline constexpr int memory_size = stamps_at + 2 * (slot_head + 8);
inline constexpr std::uint32_t stamp_layout = 0x73746d01;

/// Who makes the command that the controller follows.
enum class Control : std::uint8_t { manual, gait, mission, count };
inline constexpr const char* control_names[int(Control::count)] = {"manual", "gait", "mission"};

/// Whether a robot that is called home, and has no way home, comes up; in vain it does so once.
enum class Ascent : std::uint8_t { none, on, vain };

/// What everybody may know of the vehicle: as it was at the end of the last tick.
struct Snapshot {
    std::uint32_t tick;
    float time;  // s since boot
    PilotReadings<float> readings;
    ControllerOutput<float> output;
    Command<float> command;
    Estimate<float> estimate;
    Mode mode;        // of the pilot
    Reasons reasons;  // of the pilot
    int leg;          // waypoint that it swims to
    Control control;
    bool armed;
    Faults faults;
    Answer answer;
    float battery_left;  // part of the charge, 0 to 1
    float load;          // part of a tick's time that the last one took
};

/// What a tick took, in counts of the board's clock.
struct Profile {
    std::uint32_t controller, pilot, whole, link;  // the link's before that tick
};

struct Vehicle {
    const Description* robot;
    float value[most_parameters];
    Model model;
    Raw raw;
    PilotState<float> state;
    SupervisorMemory memory;
    std::uint8_t kept[most_kept];  // the parameters, whether there is a key, and the key
    KeptMission plan;
    std::uint64_t stamp;  // of signatures: later than all that were believed
    Store store, missions, stamps;
    BlackBox box;
    Snapshot now;
    Profile profile;
    Mission<float> mission;
    bool has_mission, way_home;  // on board; sent or begun since boot, so that it is a way home
    Mission<float> up;           // of an ascent
    Ascent ascent;
    std::uint32_t ascent_ends;  // tick at which it is in vain
    bool remembered;            // the origin is a kept mission's, and no fix came since boot
    Origin origin;
    Command<float> asked;           // by the link
    std::uint32_t heard, asked_at;  // ticks of the last sign of life of the ground, of its last beat
    bool key;                       // to sign with
    bool defaults, woken;           // no stored parameters; booted by the watchdog
    std::uint32_t lost;             // records until the last tick
};

inline const Snapshot& snapshot(const Vehicle& vehicle) { return vehicle.now; }

/// The ground is alive: called for every valid frame of its.
inline void heard(Vehicle& vehicle) { vehicle.heard = vehicle.now.tick; }

inline const Origin& origin(const Vehicle& vehicle) { return vehicle.origin; }
inline const Mission<float>& mission(const Vehicle& vehicle) { return vehicle.mission; }
inline const Pilot<float>* pilot(const Vehicle& vehicle) { return &vehicle.model.pilot; }
inline const Limits& limits(const Vehicle& vehicle) { return vehicle.model.limits; }

// --- parameters

inline int parameter_count(const Vehicle& vehicle) { return vehicle.robot->parameters; }
inline const ParameterInfo& parameter(const Vehicle& vehicle, int k) { return vehicle.robot->parameter[k]; }
inline float value(const Vehicle& vehicle, int k) { return vehicle.value[k]; }

/// Bytes that are kept: the parameters, whether there is a key, and the key.
inline int kept_size(const Description& robot) { return 4 * robot.parameters + 4 + key_size; }

/// Set a parameter; the store keeps it. Only while disarmed.
inline Refusal set_parameter(Vehicle& vehicle, int k, float to) {
    const Description& robot = *vehicle.robot;
    if (k < 0 || k >= robot.parameters) return Refusal::unknown;
    if (vehicle.now.armed) return Refusal::armed;
    const ParameterInfo& info = robot.parameter[k];
    if (!in_range(info, to)) return Refusal::out_of_range;
    if (to == vehicle.value[k] && !vehicle.store.failed) return Refusal::none;  // the memory wears
    const float before = vehicle.value[k];
    vehicle.value[k] = to;
    configure(vehicle.model, robot, vehicle.value, info.field);
    if (!consistent(vehicle.model) || (vehicle.model.limits.sign == 1.0f && !vehicle.key)) {
        vehicle.value[k] = before;
        configure(vehicle.model, robot, vehicle.value, info.field);
        return Refusal::inconsistent;
    }
    std::memcpy(vehicle.kept + 4 * k, &to, 4);
    keep(vehicle.store);
    return Refusal::none;
}

/// Key that orders are signed with; null where there is none.
inline const std::uint8_t* key(const Vehicle& vehicle) {
    return vehicle.key ? vehicle.kept + kept_size(*vehicle.robot) - key_size : nullptr;
}
/// Keep a key; one of zeros is none.
inline Refusal set_key(Vehicle& vehicle, const std::uint8_t (&to)[key_size]) {
    if (vehicle.now.armed) return Refusal::armed;
    std::uint8_t* at = vehicle.kept + kept_size(*vehicle.robot) - key_size - 4;
    vehicle.key = false;
    for (std::uint8_t byte : to) vehicle.key = vehicle.key || byte != 0;
    std::memset(at, vehicle.key, 4), std::memcpy(at + 4, to, key_size);
    keep(vehicle.store);
    return Refusal::none;
}

// --- orders

/// The tail comes to rest and the fins level.
inline Command<float> rest() {
    Command<float> command{};
    command.fresh = command.armed = true;
    return command;
}

/// Guidance begins a mission anew, from where the robot is.
inline void begin_mission(Vehicle& vehicle, Mission<float>& mission) {
    mission.start = {vehicle.now.estimate.x, vehicle.now.estimate.y};
    vehicle.state.guidance = init(vehicle.model.pilot.guidance, mission);
    vehicle.state.wait = 0;
}

/// All faults, and the answer to them.
inline void weigh_faults(Vehicle& vehicle) {
    Snapshot& now = vehicle.now;
    now.faults = all(vehicle.memory);
    now.faults.set(Fault::watchdog, vehicle.woken);
    now.faults.set(Fault::defaults, vehicle.defaults);
    now.faults.set(Fault::memory, vehicle.store.failed || vehicle.missions.failed || vehicle.stamps.failed);
    now.answer = answer_to(now.faults);
}

/// Up from here, with a mission that has no waypoints and is at home everywhere: guidance circles about the place,
/// slowly and with its fins up, and knows what to do without IMU, depth or a fin.
inline void begin_ascent(Vehicle& vehicle) {
    Mission<float>& up = vehicle.up;
    up = {};
    up.home = {vehicle.now.estimate.x, vehicle.now.estimate.y};
    up.home_radius = up.depth_most = 1e4f, up.home_speed = vehicle.model.pilot.guidance.slow;
    begin_mission(vehicle, up);
    vehicle.state.guidance.rising = false;  // without waiting for a fix
    vehicle.state.guidance.reasons.tell(Reason::recalled);
    const Guidance<float>& guidance = vehicle.model.pilot.guidance;
    const float most = clamp(time_home(guidance, vehicle.now.estimate, up), 0.0f, 3600.0f);
    vehicle.ascent_ends = vehicle.now.tick + std::uint32_t(most / vehicle.model.pilot.controller.tick);
}

/// Arm or disarm. Disarming is never refused.
inline Refusal arm(Vehicle& vehicle, bool on) {
    if (!on) {
        vehicle.now.armed = false;
        vehicle.now.control = Control::gait;
        return Refusal::none;
    }
    if (vehicle.now.armed) return Refusal::none;
    if (forbid(vehicle.memory.present)) return Refusal::faulty;
    if (!settled(vehicle.store) || !settled(vehicle.missions)) return Refusal::busy;
    if (!vehicle.now.estimate.attitude) return Refusal::not_ready;
    vehicle.memory.latched = {};
    vehicle.memory.present.set(Fault::link_gone, false);  // the ground is heard: it arms
    vehicle.woken = false;
    weigh_faults(vehicle);
    vehicle.now.armed = true;
    vehicle.now.control = Control::gait;
    vehicle.ascent = Ascent::none;
    vehicle.asked = rest();
    vehicle.asked_at = vehicle.heard = vehicle.now.tick;
    return Refusal::none;
}

/// Change who makes the command: the mission, or the ground, whose tail rests until it asks for a beat.
inline Refusal ask_control(Vehicle& vehicle, Control control) {
    if (control >= Control::count) return Refusal::unknown;
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (control != Control::mission && Answer::home <= vehicle.now.answer) return Refusal::faulty;
    if (control == Control::mission) {
        if (!vehicle.has_mission) return Refusal::no_mission;
        if (vehicle.now.control != Control::mission) begin_mission(vehicle, vehicle.mission);
        vehicle.way_home = true;
    }
    vehicle.asked = rest();
    vehicle.asked_at = vehicle.now.tick;
    vehicle.now.control = control;
    return Refusal::none;
}

/// Whether a controller would follow a command to the letter.
inline bool within(const Controller<float>& model, const Command<float>& command) {
    const auto in = [](float low, float x, float high) { return low <= x && x <= high; };
    bool good = in(0, command.frequency, model.frequency_most);
    for (int j = 0; j < model.joints; ++j) {
        const float most = model.joint[j].amplitude, turn = float(2 * pi);
        good = good && in(0, command.amplitude[j], most) && in(-turn, command.phase[j], turn) &&
               in(-most, command.bias[j], most);
    }
    for (int k = 0; k < 2; ++k) good = good && in(-model.fin_most, command.fin[k], model.fin_most);
    return good;
}

/// A beat of the ground. What is called home, or must rest, follows none.
inline Refusal ask_beat(Vehicle& vehicle, const Command<float>& command, Control control) {
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (Answer::home <= vehicle.now.answer) return Refusal::faulty;
    if (!within(vehicle.model.pilot.controller, command)) return Refusal::out_of_range;
    vehicle.asked = command;
    vehicle.asked.armed = true;
    vehicle.asked_at = vehicle.now.tick;
    vehicle.now.control = control;
    return Refusal::none;
}

/// A beat that goes on while the ground is heard.
inline Refusal ask_gait(Vehicle& vehicle, const Command<float>& command) {
    return ask_beat(vehicle, command, Control::gait);
}

/// A beat of the joystick, which ends when no next one comes in time.
inline Refusal ask_manual(Vehicle& vehicle, const Command<float>& command) {
    return ask_beat(vehicle, command, Control::manual);
}

/// The nearest command that a controller would follow to the letter.
inline void bring_within(const Controller<float>& model, Command<float>& command) {
    command.frequency = min(command.frequency, model.frequency_most);
    for (int j = 0; j < model.joints; ++j) {
        const float most = model.joint[j].amplitude;
        command.amplitude[j] = min(command.amplitude[j], most);
        command.bias[j] = clamp(command.bias[j], -most, most);
    }
    for (float& fin : command.fin) fin = clamp(fin, -model.fin_most, model.fin_most);
}

/// The same by the gait table: ahead from 0 to 1 of the fastest speed, turn to port and climb from -1 to 1. A limit
/// that was made tighter holds it back; not asked ahead, the tail does not stop in mid-beat but straightens.
inline Refusal ask_manual(Vehicle& vehicle, float ahead, float turn, float climb) {
    if (!(0 <= ahead && ahead <= 1 && abs(turn) <= 1 && abs(climb) <= 1)) return Refusal::out_of_range;
    const Steering<float>& steering = vehicle.model.pilot.guidance.steering;
    Command<float> command = rest();
    const float top = steering.table.speed[steering.table.gaits - 1];
    beat_into(steering, command, ahead * top, -turn);
    for (int j = 0; j < most_joints && ahead == 0.0f; ++j) command.amplitude[j] = 0.0f;
    command.fin[0] = command.fin[1] = climb * steering.fin_most;
    bring_within(vehicle.model.pilot.controller, command);
    return ask_manual(vehicle, command);
}

/// Keep the mission on board, and where it counts from. It is written while disarmed.
inline void keep_mission(Vehicle& vehicle) {
    const Origin& origin = vehicle.origin;
    vehicle.plan.placed = origin.known, vehicle.plan.latitude = origin.latitude;
    vehicle.plan.longitude = origin.longitude;
    keep(vehicle.missions);
}

/// Take over a mission: copied, checked as a whole, refused as a whole.
inline Refusal set_mission(Vehicle& vehicle, const Mission<float>& mission) {
    if (vehicle.now.armed && vehicle.now.control == Control::mission) return Refusal::busy;
    if (mission.waypoints > most_waypoints || mission.corners > most_corners) return Refusal::too_many;
    if (!fits(mission.waypoints, mission.corners) || !sound(mission)) return Refusal::out_of_range;
    take_mission(vehicle.plan, mission);
    vehicle.mission = mission_of(vehicle.plan);
    vehicle.has_mission = vehicle.way_home = true, vehicle.ascent = Ascent::none;
    keep_mission(vehicle);
    return Refusal::none;
}

/// Forget the mission on board, and the one that is kept.
inline Refusal clear_mission(Vehicle& vehicle) {
    if (vehicle.now.armed && vehicle.now.control == Control::mission) return Refusal::busy;
    if (!vehicle.has_mission) return Refusal::none;
    vehicle.has_mission = false, vehicle.mission = {};
    std::memset(static_cast<void*>(&vehicle.plan), 0, sizeof(vehicle.plan));
    keep(vehicle.missions);
    return Refusal::none;
}

/// Begin at a place.
inline void place_at(Vehicle& vehicle, float x, float y) {
    const float start[2] = {x, y};
    vehicle.state.estimator.way = init(vehicle.model.pilot.estimator, start).way;
    vehicle.remembered = false;
}

/// Say where local coordinates count from, and where the robot is; not before that the first fix does. Those of a
/// mission on board stay what they are.
inline Refusal set_origin(Vehicle& vehicle, std::int32_t latitude, std::int32_t longitude, float x = 0, float y = 0) {
    if (vehicle.now.armed) return Refusal::armed;
    if (!is_place(latitude, longitude)) return Refusal::out_of_range;
    if (!(abs(x) < 1e5f && abs(y) < 1e5f)) return Refusal::out_of_range;
    const Origin& before = vehicle.origin;
    const bool same = before.known && before.latitude == latitude && before.longitude == longitude;
    if (vehicle.has_mission && before.known && !same) return Refusal::elsewhere;
    vehicle.origin = origin_at(latitude, longitude);
    if (vehicle.has_mission && !same) keep_mission(vehicle);
    place_at(vehicle, x, y);
    return Refusal::none;
}

/// The first fix since boot: coordinates count from it, unless a mission was kept with an origin of its own. Where that
/// is too far away the mission is not on board any more.
inline void meet_fix(Vehicle& vehicle, const std::int32_t (&fix)[2]) {
    if (vehicle.remembered) {
        const Corner<float> at = local(vehicle.origin, fix[0], fix[1]);
        const bool near = abs(at.x) < far_away && abs(at.y) < far_away;
        place_at(vehicle, near ? at.x : 0.0f, near ? at.y : 0.0f);
        if (near) return;
        vehicle.has_mission = vehicle.origin.known = false, vehicle.mission = {};
        if (vehicle.now.control == Control::mission) vehicle.now.control = Control::gait;  // of which none is asked
    }
    if (vehicle.origin.known) return;
    vehicle.origin = origin_at(fix[0], fix[1]);
    if (vehicle.has_mission) keep_mission(vehicle);
}

}  // namespace hypertuna::firmware
