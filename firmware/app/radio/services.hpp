/// Services for ground stations: messages on request and their intervals, list of modes, checks before arming,
/// calibration, restart.
#pragma once

#include "app/radio/parameter_protocol.hpp"

namespace hypertuna::firmware {

/// Return a parameter as a whole number from 0 to `high`; -1 if it is not one.
inline int whole_of(float value, int high) {
    if (!(0.0f <= value && value <= float(high))) return -1;
    const int number = int(value);
    return float(number) == value ? number : -1;
}

/// Stream of the message with a number; -1 for none.
inline int stream_of_message(float number) {
    const int id = whole_of(number, 1 << 24);
    return id < 0 ? -1 : stream_index(std::uint32_t(id));
}

/// Set the interval [us] of a message: 0 for the interval at boot, -1 for never, otherwise one tick to a minute.
inline Refusal interval_command(Radio& radio, const mavlink_command_long_t& m) {
    const int k = stream_of_message(m.param1);
    if (k < 0) return Refusal::unknown;
    const bool heart = k == 0, never = m.param2 == -1.0f;
    if (!never && m.param2 != 0.0f && !(1e4f <= m.param2 && m.param2 <= 6e7f)) return Refusal::out_of_range;
    if (heart && (never || 1e6f < m.param2))
        return Refusal::out_of_range;  // without a heartbeat, clients report a lost link
    radio.telemetry.stream[k].interval = never              ? 0
                                         : m.param2 == 0.0f ? telemetry_messages[k].interval
                                                            : std::uint32_t(m.param2 * 1e-4f + 0.5f);
    return Refusal::none;
}

/// Answer with the interval of a message [us]: 0 for an unknown message, -1 for one on request.
inline Refusal get_interval_command(Radio& radio, const mavlink_command_long_t& m) {
    const int id = whole_of(m.param1, 65535), k = stream_of_message(m.param1);
    if (id < 0) return Refusal::out_of_range;
    mavlink_message_interval_t out{};
    out.message_id = std::uint16_t(id);
    const std::uint32_t interval = 0 <= k ? radio.telemetry.stream[k].interval : 0;
    out.interval_us = k < 0 ? 0 : interval == 0 ? -1 : std::int32_t(interval * 10000);
    reply(radio.out, out);
    return Refusal::none;
}

/// Send a message once. The modes are a list: param2 is the number of one of them, 0 for all.
inline Refusal request_command(Radio& radio, const Vehicle& vehicle, const mavlink_command_long_t& m) {
    if (m.param1 == float(MAVLINK_MSG_ID_AVAILABLE_MODES)) {
        const int mode = whole_of(m.param2, selectable_modes);
        if (mode < 0) return Refusal::out_of_range;
        radio.mode_next = mode == 0 ? 0 : mode - 1, radio.mode_end = mode == 0 ? selectable_modes : mode;
        return Refusal::none;
    }
    const int k = stream_of_message(m.param1);
    if (k < 0) return Refusal::unknown;
    if (telemetry_messages[k].placed && !is_placed(vehicle)) return Refusal::not_placed;
    radio.telemetry.stream[k].requested = true;
    return Refusal::none;
}

/// Send the next mode of the list; false if there is none.
inline bool send_next_mode(Radio& radio) {
    if (radio.mode_end <= radio.mode_next) return false;
    send(radio.out, radio.signing, available_mode(radio.mode_next++));
    return true;
}

/// Report what forbids arming; SYS_STATUS has the result, too.
inline Refusal prearm_command(Radio& radio, const Vehicle& vehicle, Peer from) {
    if (snapshot(vehicle).armed()) return Refusal::armed;
    const Refusal refusal = check(vehicle, Order::arm, from);
    radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_SYS_STATUS)].requested = true;
    if (refusal == Refusal::none) send_text(radio, MAV_SEVERITY_INFO, "ready to be armed");
    if (refusal != Refusal::none) send_text(radio, MAV_SEVERITY_WARNING, sentence(vehicle, refusal));
    return Refusal::none;
}

/// Restart the firmware once the answer is sent.
inline Refusal reboot_command(Radio& radio, const Vehicle& vehicle, const mavlink_command_long_t& m) {
    if (snapshot(vehicle).armed()) return Refusal::armed;
    if (m.param1 != 1.0f) return Refusal::unknown;  // shutdown, bootloader
    if (check(vehicle, Need::stored) != Refusal::none) return Refusal::busy;
    radio.restart_at = snapshot(vehicle).tick + restart_delay;
    return Refusal::none;
}

inline constexpr std::uint32_t gyro_ticks = 100;  // ticks of a calibration of the gyroscope
inline constexpr float gyro_still = 0.05f;        // rad/s: largest range of the readings while the robot is still

/// Calibrate the gyroscope at rest, or take the present depth as the surface. Accelerometer and compass can be
/// calibrated only while the robot is turned, by `hypertuna radio calibrate`.
inline Refusal calibration_command(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    if (m.param2 != 0.0f || m.param4 != 0.0f || m.param5 != 0.0f || m.param6 != 0.0f || m.param7 != 0.0f)
        return Refusal::by_program;
    if (m.param1 == 1.0f && m.param3 == 0.0f) {
        const Refusal refusal = check(vehicle, Order::set_parameter, from);
        if (refusal == Refusal::none) radio.gyro = {from, gyro_ticks, {}, {}, {}};
        return refusal;
    }
    if (m.param1 == 0.0f && m.param3 == 1.0f) return take_surface(vehicle, from);
    return m.param1 == 0.0f && m.param3 == 0.0f ? Refusal::none : Refusal::by_program;
}

/// Collect the samples of the gyroscope's calibration; at its end set the zeros.
inline void calibrate_gyro(Radio& radio, Vehicle& vehicle) {
    GyroCalibration& gyro = radio.gyro;
    if (gyro.left == 0) return;
    constexpr int first = first_channel("rate");
    bool known = true, still = true;
    for (int k = 0; k < 3; ++k) {
        const float counts = mean(vehicle.raw.channel[first + k]);
        known = known && is_finite(counts);
        if (!is_finite(counts)) continue;
        gyro.low[k] = gyro.left == gyro_ticks ? counts : min(gyro.low[k], counts);
        gyro.high[k] = gyro.left == gyro_ticks ? counts : max(gyro.high[k], counts);
        gyro.sum[k] += counts;
        const float step = abs(vehicle.model.calibration.scale[first + k]);
        still = still && (gyro.high[k] - gyro.low[k]) * step < gyro_still;
    }
    --gyro.left;
    if (!known || !still) {
        gyro.left = 0;
        return send_text(radio, MAV_SEVERITY_WARNING, "gyroscope not calibrated: it must lie still");
    }
    if (gyro.left != 0) return;
    Refusal refusal = Refusal::none;
    char name[] = "rate_zero_0";
    for (int k = 0; k < 3 && refusal == Refusal::none; ++k) {
        name[sizeof name - 2] = char('0' + k);
        const int number = parameter_named(vehicle, name);
        refusal = set_parameter(vehicle, gyro.from, number, gyro.sum[k] / float(gyro_ticks));
    }
    if (refusal == Refusal::none) return send_text(radio, MAV_SEVERITY_INFO, "gyroscope calibrated");
    report_refusal(radio, vehicle, refusal);
}

}  // namespace hypertuna::firmware
