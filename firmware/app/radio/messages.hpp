/// Telemetry messages: functions that make them from the vehicle's snapshot at the moment of sending, and the table of
/// all.
#pragma once

#include <concepts>

#include "app/radio/mission_download.hpp"
#include "app/radio/modes.hpp"
#include "app/radio/outbox.hpp"

namespace hypertuna::firmware {

/// Roll (starboard down), pitch (nose up), heading (clockwise from north) and their rates in axes forward, starboard,
/// down, from those of docs/conventions.md: x to the tail, y to starboard, z up; world east, north, up.
inline mavlink_attitude_t attitude(const Snapshot& now) {
    const Estimate<float>& at = now.estimate;
    const Quaternion<float>& q = at.q;
    const float starboard_up = 2.0f * (q.y * q.z + q.w * q.x), up_up = 1.0f - 2.0f * (q.x * q.x + q.y * q.y);
    const Vector<float>& ahead = at.facing;
    const float level = sqrt(ahead.x * ahead.x + ahead.y * ahead.y);
    mavlink_attitude_t m{};
    m.time_boot_ms = milliseconds(now);
    m.roll = angle_of(-starboard_up, up_up), m.pitch = angle_of(ahead.z, level), m.yaw = angle_of(ahead.x, ahead.y);
    m.rollspeed = -at.rate.x, m.pitchspeed = at.rate.y, m.yawspeed = -at.rate.z;
    return m;
}

inline mavlink_hydraulics_t hydraulics(const Snapshot& now) {
    const Readings<float>& r = now.readings.robot;
    const auto hectopascal = [](float p) { return whole<std::int16_t>(p, 0.01f); };
    const auto centi = [](float i) { return whole<std::int16_t>(i, 100.0f); };
    mavlink_hydraulics_t m{};
    static_assert(sizeof m.bend + sizeof m.bend_34 == max_joints * sizeof *m.bend);
    m.time_boot_ms = milliseconds(now), m.condition = now.output.status.flags;
    for (int j = 0; j < 2; ++j) {
        m.bend[j] = whole<std::int16_t>(r.bend[j], centidegree);
        m.bend_34[j] = whole<std::int16_t>(r.bend[j + 2], centidegree);
    }
    for (int c = 0; c < 4; ++c) {
        m.pressure[c] = hectopascal(r.pressure[c]), m.pressure_34[c] = hectopascal(r.pressure[c + 4]);
        m.current[c] = centi(r.current[c]), m.current_34[c] = centi(r.current[c + 4]);
    }
    return m;
}

inline mavlink_gait_t gait(const Snapshot& now) {
    const Command<float>& c = now.command;
    const auto angle = [](float a) { return whole<std::int16_t>(a, centidegree); };
    mavlink_gait_t m{};
    static_assert(sizeof m.amplitude + sizeof m.amplitude_34 == max_joints * sizeof *m.amplitude);
    m.time_boot_ms = milliseconds(now), m.frequency = whole<std::uint16_t>(c.frequency, 1000.0f);
    for (int j = 0; j < 2; ++j) {
        m.amplitude[j] = angle(c.amplitude[j]), m.amplitude_34[j] = angle(c.amplitude[j + 2]);
        m.lag[j] = angle(c.phase[j]), m.lag_34[j] = angle(c.phase[j + 2]);
        m.bias[j] = angle(c.bias[j]), m.bias_34[j] = angle(c.bias[j + 2]);
        m.fin[j] = angle(c.fin[j]);
    }
    m.state = std::uint8_t(custom_mode(now));
    return m;
}

inline mavlink_pilot_t pilot_state(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const Estimate<float>& at = now.estimate;
    mavlink_pilot_t m{};
    m.time_boot_ms = milliseconds(now), m.reason = now.reasons.flags, m.fault = now.faults.flags;
    m.position_error = is_place_lost(vehicle) ? 0xFFFF : whole<std::uint16_t>(at.position_error, 100.0f);
    m.current[0] = whole<std::int16_t>(at.current[1], 1000.0f);
    m.current[1] = whole<std::int16_t>(at.current[0], 1000.0f);
    m.speed = whole<std::int16_t>(at.speed, 1000.0f);
    m.mode = std::uint8_t(now.mode), m.leg = std::uint8_t(now.leg);
    return m;
}

inline mavlink_servo_output_raw_t servo_output(const Snapshot& now) {
    const float* pulse = now.output.pulse;
    const auto micro = [pulse](int k) { return whole<std::uint16_t>(pulse[k], 1e6f); };
    mavlink_servo_output_raw_t m{};
    m.time_usec = now.tick * 10000;
    m.servo1_raw = micro(0), m.servo2_raw = micro(1), m.servo3_raw = micro(2), m.servo4_raw = micro(3);
    m.servo5_raw = micro(4), m.servo6_raw = micro(5), m.servo7_raw = micro(6), m.servo8_raw = micro(7);
    m.servo9_raw = micro(8), m.servo10_raw = micro(9);
    return m;
}

inline mavlink_heartbeat_t heartbeat(const Snapshot& now) {
    const bool worst = now.armed() && is_critical(now.faults);
    mavlink_heartbeat_t m{};
    m.custom_mode = custom_mode(now);
    m.type = MAV_TYPE_SUBMARINE, m.autopilot = MAV_AUTOPILOT_GENERIC;
    m.base_mode = MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (now.armed() ? MAV_MODE_FLAG_SAFETY_ARMED : 0) |
                  (now.state == State::manual ? MAV_MODE_FLAG_MANUAL_INPUT_ENABLED : 0) |
                  (is_guided(now.state) ? MAV_MODE_FLAG_AUTO_ENABLED : 0);
    m.system_status = std::uint8_t(worst ? MAV_STATE_CRITICAL : now.armed() ? MAV_STATE_ACTIVE : MAV_STATE_STANDBY);
    m.mavlink_version = 3;
    return m;
}

inline int percent(float part) { return is_finite(part) ? int(clamp(part, 0.0f, 1.0f) * 100.0f + 0.5f) : -1; }

/// `prearm` is healthy if the robot is armed, or would be on command. The receiver is healthy with a fix that is
/// believed; under water it has none.
inline mavlink_sys_status_t sys_status(const Vehicle& vehicle, const Parser& parser) {
    const Snapshot& now = snapshot(vehicle);
    const Refusal refusal = check(vehicle, Order::arm, Station{});
    const float bad = float(parser.bad);
    const Status& status = now.output.status;
    const std::uint32_t imu = MAV_SYS_STATUS_SENSOR_3D_GYRO | MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    const std::uint32_t others = MAV_SYS_STATUS_SENSOR_3D_MAG | MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE;
    const std::uint32_t battery = MAV_SYS_STATUS_SENSOR_BATTERY, motors = MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS;
    const std::uint32_t compass = now.estimate.compass ? MAV_SYS_STATUS_SENSOR_3D_MAG : 0u;
    const std::uint32_t depth = now.estimate.depths ? MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE : 0u;
    const std::uint32_t gps = MAV_SYS_STATUS_SENSOR_GPS, prearm = MAV_SYS_STATUS_PREARM_CHECK;
    const bool stopped = status.has(Condition::hard_stop), ready = now.armed() || refusal == Refusal::none;
    const bool fixed = vehicle.fix.any && now.tick - vehicle.fix.tick <= fix_lasts && !now.estimate.fixes_refused;
    const Mission<float>& fence = mission(vehicle);
    const bool fenced = 0 < fence.corners || 0.0f < fence.range, inside = !fenced || holds(fence, here(vehicle));
    const std::uint32_t geofence = MAV_SYS_STATUS_GEOFENCE;
    mavlink_sys_status_t m{};
    m.onboard_control_sensors_present = imu | others | battery | motors | gps | prearm | (fenced ? geofence : 0);
    m.onboard_control_sensors_enabled =
        imu | others | battery | gps | prearm | (fenced ? geofence : 0) | (now.armed() ? motors : 0);
    m.onboard_control_sensors_health = (status.has(Condition::imu_fault) ? 0 : imu) | compass | depth |
                                       (status.has(Condition::battery_fault) ? 0 : battery) | (stopped ? 0 : motors) |
                                       (fixed ? gps : 0) | (ready ? prearm : 0) | (inside ? geofence : 0);
    m.load = whole<std::uint16_t>(now.load, 1000.0f);
    m.voltage_battery = whole<std::uint16_t>(now.readings.robot.voltage, 1000.0f);
    m.current_battery = -1, m.battery_remaining = std::int8_t(percent(now.battery_left));
    m.drop_rate_comm = whole<std::uint16_t>(bad / max(1.0f, float(parser.frames + parser.bad)), 10000.0f);
    m.errors_comm = whole<std::uint16_t>(bad, 1.0f);
    return m;
}

inline mavlink_battery_status_t battery_status(const Snapshot& now) {
    mavlink_battery_status_t m{};
    m.current_consumed = m.energy_consumed = -1, m.temperature = std::numeric_limits<std::int16_t>::max();
    for (int k = 1; k < 10; ++k) m.voltages[k] = 0xFFFF;  // the battery's voltage, not the cells'
    m.voltages[0] = whole<std::uint16_t>(now.readings.robot.voltage, 1000.0f);
    m.current_battery = -1, m.type = MAV_BATTERY_TYPE_LION, m.battery_function = MAV_BATTERY_FUNCTION_ALL;
    m.battery_remaining = std::int8_t(percent(now.battery_left));
    return m;
}

/// Origin of local coordinates; zeros before the first fix.
inline mavlink_gps_global_origin_t global_origin(const Vehicle& vehicle) {
    const Origin& at = origin(vehicle);
    mavlink_gps_global_origin_t m{};
    if (at.known) m.latitude = at.latitude, m.longitude = at.longitude;
    return m;
}

/// Counts of accelerometer, gyroscope and compass, as converted last, in the robot's axes: for calibration.
inline mavlink_raw_imu_t raw_imu(const Vehicle& vehicle) {
    const auto counts = [&](int channel) { return whole<std::int16_t>(mean(vehicle.raw.channel[channel]), 1.0f); };
    constexpr int acceleration = first_channel("acceleration"), rate = first_channel("rate");
    constexpr int field = first_channel("field");
    mavlink_raw_imu_t m{};
    m.time_usec = snapshot(vehicle).tick * 10000ull, m.temperature = 0;
    m.xacc = counts(acceleration), m.yacc = counts(acceleration + 1), m.zacc = counts(acceleration + 2);
    m.xgyro = counts(rate), m.ygyro = counts(rate + 1), m.zgyro = counts(rate + 2);
    m.xmag = counts(field), m.ymag = counts(field + 1), m.zmag = counts(field + 2);
    return m;
}

/// Absolute pressure of the depth sensor; NaN where it does not answer. Its temperature is not read.
inline mavlink_scaled_pressure_t scaled_pressure(const Vehicle& vehicle) {
    mavlink_scaled_pressure_t m{};
    m.time_boot_ms = milliseconds(snapshot(vehicle)), m.temperature = std::numeric_limits<std::int16_t>::max();
    m.press_abs = 0.1f * mean(vehicle.raw.channel[first_channel("depth")]);  // hPa: a count is 10 Pa
    return m;
}

inline mavlink_autopilot_version_t autopilot_version(const Snapshot&) {
    mavlink_autopilot_version_t m{};
    m.capabilities = MAV_PROTOCOL_CAPABILITY_MISSION_INT | MAV_PROTOCOL_CAPABILITY_COMMAND_INT |
                     MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST | MAV_PROTOCOL_CAPABILITY_MAVLINK2 |
                     MAV_PROTOCOL_CAPABILITY_MISSION_FENCE | MAV_PROTOCOL_CAPABILITY_FTP;
    return m;
}

inline mavlink_protocol_version_t protocol_version(const Snapshot&) {
    mavlink_protocol_version_t m{};
    m.version = m.min_version = m.max_version = 200;
    return m;
}

/// Address of the description of the parameters (files.hpp): the first file names the others.
inline mavlink_component_metadata_t component_metadata(const Vehicle& vehicle) {
    const char scheme[] = "mftp://";
    mavlink_component_metadata_t m{};
    m.time_boot_ms = milliseconds(snapshot(vehicle));
    if (vehicle.robot->files == 0) return m;
    const FileInfo& general = vehicle.robot->file[0];
    m.file_crc = general.crc;
    std::memcpy(m.uri, scheme, sizeof scheme - 1);
    for (std::size_t k = 0; general.name[k] != 0; ++k) m.uri[sizeof scheme - 1 + k] = general.name[k];
    return m;
}

/// A telemetry message: its id, its interval at boot, and how it is made and sent.
struct TelemetryMessage {
    std::uint32_t id;
    std::uint32_t interval;  // ticks of 10 ms; 0 for on request only
    bool placed;             // the message needs the place on the map
    void (*send)(Outbox&, Signing&, const Vehicle&, const Parser&);
};

/// Make a message from the vehicle, from its snapshot, or from the vehicle and the parser's counters.
template <auto make>
auto made(const Vehicle& vehicle, const Parser& parser) {
    using Maker = decltype(make);
    if constexpr (std::invocable<Maker, const Vehicle&>)
        return make(vehicle);
    else if constexpr (std::invocable<Maker, const Snapshot&>)
        return make(snapshot(vehicle));
    else
        return make(vehicle, parser);
}

template <auto make>
void send_made(Outbox& out, Signing& signing, const Vehicle& vehicle, const Parser& parser) {
    send(out, signing, made<make>(vehicle, parser));
}

/// Row of the table: the message that `make` returns, every `interval` ticks.
template <auto make>
constexpr TelemetryMessage every(std::uint32_t interval, bool placed = false) {
    using Message = decltype(made<make>(std::declval<const Vehicle&>(), std::declval<const Parser&>()));
    return {kind_of<Message>.id, interval, placed, send_made<make>};
}

/// Table of all telemetry. The heartbeat is first: it is never late because of another message. The position is sent in
/// local coordinates and in degrees, each every two seconds. Whether there is a fix, and whether the robot is at the
/// surface, changes within seconds; home seldom changes. The other messages are sent on request, since their numbers
/// are in these, too.
inline constexpr TelemetryMessage telemetry_messages[] = {
    every<heartbeat>(100),
    every<hydraulics>(20),
    every<attitude>(25),
    every<local_position>(200),
    every<gait>(200),
    every<pilot_state>(200),
    every<servo_output>(200),
    every<sys_status>(500),
    every<battery_status>(1000),
    every<mission_current>(1000),
    every<global_position>(200, true),
    every<gps_raw>(500),
    every<extended_state>(500),
    every<home_position>(2000, true),
    every<hud>(0),
    every<current_mode>(0),
    every<modes_monitor>(0),
    every<autopilot_version>(0),
    every<protocol_version>(0),
    every<component_metadata>(0),
    every<global_origin>(0, true),
    every<raw_imu>(0),
    every<scaled_pressure>(0),
};
inline constexpr int streams = int(sizeof(telemetry_messages) / sizeof(telemetry_messages[0]));

}  // namespace hypertuna::firmware
