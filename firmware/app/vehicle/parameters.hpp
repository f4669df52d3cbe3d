/// Parameters: the numbers of one robot, and those that may be set over the radio.
///
/// `hypertuna firmware params` writes a Description from robots/NAME.toml: every number of pilot, controller,
/// calibration and limits in one row, in the order of visit_fields. A parameter is a number of that row that may be set
/// within a range.
#pragma once

#include "app/vehicle/convert.hpp"
#include "hypertuna/pilot/pilot.hpp"

namespace hypertuna::firmware {

inline constexpr int max_parameters = 76 + 13 * board_joints;  // a robot has 71 and 13 per joint

/// Limits of supervisor and radio.
struct Limits {
    float manual_timeout, link_timeout,
        home_timeout;  // s without joystick; without the ground; without the ground until the robot is called home
    float voltage_empty, voltage_after;  // V; s for which the voltage must be below
    float tilt_max, tilt_after;          // sine of roll or pitch; s for which it must be above
    float leak_after;                    // s of water in the hull until it is a leak
    float rise_depth;                    // m: from below this the robot ascends if it has no way home
    float depth_max;                     // m: largest depth outside missions
    float link_rate, link_share;         // bit/s of the radio; fraction for telemetry
    float system_id;                     // system id of the robot in MAVLink
    float sign;                          // 1: commands must be signed
    float leak_answer, snag_answer, stroke_answer, guard_answer;  // Answer to each of these faults
    float snag_distance;    // m swum on a course without moving over ground until it is a fault; 0: never one
    float sink_depth;       // m that a robot at rest may sink
    float beacon_interval;  // s between two beacons of a robot whose mission has ended
};

/// All constants of the firmware.
struct Model {
    Pilot<float> pilot;
    Calibration calibration;
    Limits limits;
};

template <class Visit>
void visit_fields(Limits& m, const Visit& visit) {
    visit("manual_timeout", 0, m.manual_timeout), visit("link_timeout", 0, m.link_timeout);
    visit("home_timeout", 0, m.home_timeout), visit("voltage_empty", 0, m.voltage_empty);
    visit("voltage_after", 0, m.voltage_after), visit("tilt_max", 0, m.tilt_max);
    visit("tilt_after", 0, m.tilt_after), visit("leak_after", 0, m.leak_after);
    visit("rise_depth", 0, m.rise_depth), visit("depth_max", 0, m.depth_max);
    visit("link_rate", 0, m.link_rate), visit("link_share", 0, m.link_share);
    visit("system_id", 0, m.system_id), visit("sign", 0, m.sign);
    visit("leak_answer", 0, m.leak_answer), visit("snag_answer", 0, m.snag_answer);
    visit("stroke_answer", 0, m.stroke_answer), visit("guard_answer", 0, m.guard_answer);
    visit("snag_distance", 0, m.snag_distance), visit("sink_depth", 0, m.sink_depth);
    visit("beacon_interval", 0, m.beacon_interval);
}

/// Call visit(name, index, field) for every number of the model. The numbers of joints and gaits must be set before.
template <class Visit>
void visit_fields(Model& m, const Visit& visit) {
    hypertuna::visit_fields(m.pilot.controller, visit);
    hypertuna::visit_fields(m.pilot, visit);
    visit_fields(m.calibration, m.pilot.controller.joints, visit);
    visit_fields(m.limits, visit);
}

/// A number that the radio may read and set. Names have at most 16 characters.
struct ParameterInfo {
    const char* name;
    float low, high, standard;  // range, and the description's value
    bool whole;                 // a whole number
    std::int16_t field;         // index in the row of all numbers
};

/// A file for ground stations, served by the radio.
struct FileInfo {
    const char* name;
    const std::uint8_t* bytes;
    int size;
    std::uint32_t crc;
};

/// A robot's description at build time.
struct Description {
    const char* name;
    int joints, gaits;
    const float* value;  // all numbers
    int values;
    const ParameterInfo* parameter;
    int parameters;
    std::uint32_t layout;  // checksum of the parameters' names and indices: a stored set of another layout is ignored
    const FileInfo* file;
    int files;
};

/// Value of a number of the row: the parameter that replaces it, if there is one.
inline float number_at(const Description& robot, const float* parameter, int field) {
    for (int k = 0; k < robot.parameters; ++k)
        if (robot.parameter[k].field == field) return parameter[k];
    return field < robot.values ? robot.value[field] : 0.0f;
}

inline constexpr int all_fields = -1;

/// Fills one field after another, or a single field. Not inlined into every visit, which would take a quarter of the
/// program.
struct Filler {
    const Description& robot;
    const float* parameter;
    int only;
    int& at;

    template <class Field>
    HYPERTUNA_NOINLINE void operator()(const char*, int, Field& field) const {
        const int here = at++;
        if (only == all_fields || only == here) field = Field(number_at(robot, parameter, here));
    }
};

/// Fill a model, or one field of it, from the row of all numbers and the parameters.
[[gnu::cold]] inline void configure(Model& model, const Description& robot, const float* parameter,
                                    int only = all_fields) {
    model.pilot.controller.joints = model.pilot.guidance.steering.joints = robot.joints;
    model.pilot.guidance.steering.table.gaits = robot.gaits;
    int at = 0;
    visit_fields(model, Filler{robot, parameter, only, at});
}

/// Whether a value is within a parameter's range.
inline bool in_range(const ParameterInfo& info, float value) {
    return info.low <= value && value <= info.high && (!info.whole || value == float(int(value)));
}

/// Whether the pressures, pulses, time-outs and voltages are in order.
inline bool consistent(const Model& model) {
    return hypertuna::consistent(model.pilot.controller) && model.limits.link_timeout <= model.limits.home_timeout &&
           model.limits.voltage_empty < model.pilot.controller.voltage_low;
}

}  // namespace hypertuna::firmware
