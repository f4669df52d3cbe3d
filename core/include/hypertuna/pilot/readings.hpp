/// Readings: what all sensors show in one tick, and the table of their channels.
#pragma once

#include <string_view>
#include <tuple>
#include <type_traits>

#include "hypertuna/control/controller.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct PilotReadings {
    Readings<T> robot;
    T depth;     // m of the nose below the surface
    T field[3];  // magnetic field in body axes, in units of the field's strength
    T fix[2];    // m east and north, of the satellite receiver
    bool fixed;  // a fix came in this tick
    T accuracy;  // m, standard deviation of the fix by the receiver; 0 unknown
};

/// The controller's readings where the pilot's are expected.
template <class T>
PilotReadings<T> without_pilot(const Readings<T>& robot) {
    PilotReadings<T> readings{};
    readings.robot = robot;
    return readings;
}

/// Where a robot has one sensor of a kind: at each joint, at each circuit, or once.
enum class Per : std::uint8_t { joint, circuit, robot };

/// What turns the signal of a sensor into counts: the microcontroller, the sensor itself, or nothing (coordinates).
enum class Converter : std::uint8_t { analog, digital, none };

/// What first uses a reading: the controller, or only the pilot.
enum class Reader : std::uint8_t { controller, pilot };

/// A kind of sensor, and its member of the readings: one number or an array of them.
template <class Member>
struct Channel {
    const char* name;    // name in the robot's description, in Python and in the firmware's calibration
    const char* part;    // name in faults; the sensors of one part fail together
    const char* column;  // name of the column in logs
    const char* unit;
    const char* meaning;
    Per per;
    Converter converter;
    Reader reader;
    Member member;

    /// Number of channels reserved for this kind of sensor, independent of the number of joints.
    static constexpr int size = [] {
        using Field = std::remove_reference_t<std::invoke_result_t<Member, PilotReadings<float>&>>;
        return std::is_array_v<Field> ? int(std::extent_v<Field>) : 1;
    }();
    /// Number of channels on a robot with this many joints.
    constexpr int count(int joints) const {
        return per == Per::joint ? joints : per == Per::circuit ? 2 * joints : size;
    }
    /// Pointer to the first number of this kind of sensor.
    template <class R>
    constexpr auto* of(R& readings) const {
        if constexpr (size == 1)
            return &member(readings);
        else
            return &member(readings)[0];
    }
};

/// Table of all sensors. Its order is that of channel numbers, noise streams, calibration, logs and messages: a new
/// sensor of the pilot goes to the end. One of the controller goes before `depth`, which changes the noise of every run
/// (`stream_of`).
#define HYPERTUNA_MEMBER(field) [](auto& r) -> auto& { return r.field; }
inline constexpr std::tuple channel_table{
    Channel{"bend", "bend", "bend_read", "rad", "by the bend sensor",  //
            Per::joint, Converter::analog, Reader::controller, HYPERTUNA_MEMBER(robot.bend)},
    Channel{"pressure", "pressure", "pressure_read", "Pa", "gauge pressure by the sensor",  //
            Per::circuit, Converter::analog, Reader::controller, HYPERTUNA_MEMBER(robot.pressure)},
    Channel{"current", "current", "current_read", "A", "of the servo by the sensor",  //
            Per::circuit, Converter::analog, Reader::controller, HYPERTUNA_MEMBER(robot.current)},
    Channel{"rate", "imu", "turn_rate_read", "rad/s", "by the gyroscope, in body axes",  //
            Per::robot, Converter::digital, Reader::controller, HYPERTUNA_MEMBER(robot.rate)},
    Channel{"acceleration", "imu", "acceleration_read", "m/s^2", "by the accelerometer, in body axes",  //
            Per::robot, Converter::digital, Reader::controller, HYPERTUNA_MEMBER(robot.acceleration)},
    Channel{"voltage", "battery", "battery_voltage_read", "V", "of the battery by the sensor",  //
            Per::robot, Converter::analog, Reader::controller, HYPERTUNA_MEMBER(robot.voltage)},
    Channel{"depth", "depth", "depth_read", "m", "of the nose by the depth sensor",  //
            Per::robot, Converter::digital, Reader::pilot, HYPERTUNA_MEMBER(depth)},
    Channel{"field", "field", "field_read", "1", "by the compass, in body axes, over the strength of the field",  //
            Per::robot, Converter::digital, Reader::pilot, HYPERTUNA_MEMBER(field)},
    Channel{"position", "position", "fix_read", "m", "by the satellite receiver: east, north",  //
            Per::robot, Converter::none, Reader::pilot, HYPERTUNA_MEMBER(fix)},
};
#undef HYPERTUNA_MEMBER
inline constexpr int channel_kinds = std::tuple_size_v<decltype(channel_table)>;

/// Call visit(channel, first) for every kind of sensor, with the number of its first channel.
template <class Visit>
constexpr void visit_channels(const Visit& visit) {
    std::apply(
        [&](const auto&... channel) {
            int first = 0;
            ((visit(channel, first), first += channel.size), ...);
        },
        channel_table);
}

/// Number of channels of the sensors for which `select` is true.
template <class Select>
consteval int count_channels(const Select& select) {
    int count = 0;
    visit_channels([&](const auto& channel, int) { count += select(channel) ? channel.size : 0; });
    return count;
}
inline constexpr int sensor_channels = count_channels([](const auto&) { return true; });
inline constexpr int counted_channels = count_channels([](const auto& c) { return c.converter != Converter::none; });

/// Place of a kind of sensor in the table; `channel_kinds` where the table lacks it.
constexpr int channel_kind(std::string_view name) {
    int kind = channel_kinds, k = 0;
    visit_channels([&](const auto& channel, int) {
        if (channel.name == name) kind = k;
        ++k;
    });
    return kind;
}

/// First channel of a kind of sensor; the array bound refuses a name that the table lacks.
consteval int first_channel(std::string_view name) {
    int first_of[channel_kinds] = {}, k = 0;
    visit_channels([&](const auto&, int first) { first_of[k++] = first; });
    return first_of[channel_kind(name)];
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
