/// Vehicle: all of the robot's state on board, and everything that decides. The link asks, the vehicle answers.
#pragma once

#include "faults.hpp"
#include "hypertuna/pilot.hpp"
#include "refusal.hpp"

namespace hypertuna::firmware {

inline constexpr int most_waypoints = 64, most_corners = 32;

/// Who makes the command that the controller follows.
enum class Control : std::uint8_t { manual, gait, mission, count };
inline constexpr const char* control_names[int(Control::count)] = {"manual", "gait", "mission"};

/// A number that the radio may read and set. Names have 16 characters at most.
struct ParameterInfo {
    const char* name;
    float low, high, standard;  // range, and the value that the robot's description gives
    bool whole;                 // a whole number
};

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
    float battery_left;  // part of the charge, 0 to 1
    float load;          // part of the tick that the last one took
};

/// The place that local coordinates count from: the first fix, unless it is set.
struct Origin {
    std::int32_t latitude, longitude;  // 1e-7 deg
    float east, north;                 // m per 1e-7 deg
    bool known;
};

inline constexpr ParameterInfo parameter_table[] = {{"proportional", 0.0f, 1.0f, 0.1f, false},
                                                    {"integral", 0.0f, 2.0f, 0.5f, false},
                                                    {"derivative", 0.0f, 1.0f, 0.0f, false},
                                                    {"pressure_soft", 125e3f, 500e3f, 250e3f, false},
                                                    {"link_timeout", 1.0f, 60.0f, 5.0f, false}};
inline constexpr int parameter_number = int(sizeof(parameter_table) / sizeof(parameter_table[0]));

struct Vehicle {
    Snapshot now;
    float value[parameter_number];
    Waypoint<float> waypoint[most_waypoints];
    Corner<float> corner[most_corners];
    Mission<float> mission;
    bool has_mission;
    Origin origin;
    std::uint32_t heard;  // tick of the last sign of life of the ground
};

inline const Snapshot& snapshot(const Vehicle& vehicle) { return vehicle.now; }

/// The ground is alive: called for every valid frame of its heartbeat, and for every order.
inline void heard(Vehicle& vehicle) { vehicle.heard = vehicle.now.tick; }

/// Arm or disarm. Disarming is never refused.
inline Refusal arm(Vehicle& vehicle, bool on) {
    vehicle.now.armed = on;
    return Refusal::none;
}

/// Change who makes the command.
inline Refusal ask_control(Vehicle& vehicle, Control control) {
    if (control == Control::mission && !vehicle.has_mission) return Refusal::no_mission;
    vehicle.now.control = control;
    return Refusal::none;
}

/// A beat that goes on while the ground is heard; takes control for Control::gait.
inline Refusal ask_gait(Vehicle& vehicle, const Command<float>& command) {
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (!(command.frequency >= 0 && command.frequency <= 8)) return Refusal::out_of_range;
    vehicle.now.command = command, vehicle.now.control = Control::gait;
    return Refusal::none;
}

/// A beat of the joystick, which ends when no next one comes in time; takes control for Control::manual.
inline Refusal ask_manual(Vehicle& vehicle, const Command<float>& command) {
    if (!vehicle.now.armed) return Refusal::disarmed;
    if (!(command.frequency >= 0 && command.frequency <= 8)) return Refusal::out_of_range;
    vehicle.now.command = command, vehicle.now.control = Control::manual;
    return Refusal::none;
}

/// Take over a mission: copied, checked as a whole, refused as a whole.
inline Refusal set_mission(Vehicle& vehicle, const Mission<float>& mission) {
    if (mission.waypoints > most_waypoints || mission.corners > most_corners) return Refusal::too_many;
    vehicle.mission = mission;
    for (int k = 0; k < mission.waypoints; ++k) vehicle.waypoint[k] = mission.waypoint[k];
    for (int k = 0; k < mission.corners; ++k) vehicle.corner[k] = mission.corner[k];
    vehicle.mission.waypoint = vehicle.waypoint, vehicle.mission.corner = vehicle.corner;
    vehicle.has_mission = true;
    return Refusal::none;
}

/// The mission that is on board: without waypoints where there is none.
inline const Mission<float>& mission(const Vehicle& vehicle) { return vehicle.mission; }

inline Refusal clear_mission(Vehicle& vehicle) {
    vehicle.has_mission = false, vehicle.mission = {};
    return Refusal::none;
}

inline const Origin& origin(const Vehicle& vehicle) { return vehicle.origin; }

inline int parameter_count(const Vehicle&) { return parameter_number; }
inline const ParameterInfo& parameter(const Vehicle&, int k) { return parameter_table[k]; }
inline float value(const Vehicle& vehicle, int k) { return vehicle.value[k]; }

/// Set a parameter; the store keeps it. Only while disarmed.
inline Refusal set_parameter(Vehicle& vehicle, int k, float to) {
    if (vehicle.now.armed) return Refusal::armed;
    if (k < 0 || k >= parameter_number) return Refusal::unknown;
    if (!(parameter_table[k].low <= to && to <= parameter_table[k].high)) return Refusal::out_of_range;
    vehicle.value[k] = to;
    return Refusal::none;
}

/// As it boots: disarmed, everything at rest.
inline void boot(Vehicle& vehicle) {
    vehicle = {};
    for (int k = 0; k < parameter_number; ++k) vehicle.value[k] = parameter_table[k].standard;
}

}  // namespace hypertuna::firmware
