/// Telemetry: which message is sent next. Each has an interval; where the radio cannot carry all of them, every
/// interval grows by the same factor, since whatever is late by the largest part of its own goes first.
#pragma once

#include "app/radio/mission_list.hpp"
#include "app/radio/outbox.hpp"

namespace hypertuna::firmware {

/// A message that is sent again and again.
struct Schedule {
    std::uint32_t id;
    std::uint32_t interval;  // ticks as the robot boots
};

/// Ticks of 10 ms. The heartbeat is first: it is never late for another message.
inline constexpr Schedule schedules[] = {
    {MAVLINK_MSG_ID_HEARTBEAT, 100},
    {MAVLINK_MSG_ID_HYDRAULICS, 20},
    {MAVLINK_MSG_ID_ATTITUDE, 25},
    {MAVLINK_MSG_ID_LOCAL_POSITION_NED, 100},
    {MAVLINK_MSG_ID_GAIT, 200},
    {MAVLINK_MSG_ID_PILOT, 200},
    {MAVLINK_MSG_ID_SERVO_OUTPUT_RAW, 200},
    {MAVLINK_MSG_ID_SYS_STATUS, 500},
    {MAVLINK_MSG_ID_BATTERY_STATUS, 1000},
    {MAVLINK_MSG_ID_MISSION_CURRENT, 1000},
    {MAVLINK_MSG_ID_AUTOPILOT_VERSION, 0},
    {MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, 0},
};
inline constexpr int streams = int(sizeof(schedules) / sizeof(schedules[0]));

struct TelemetryStream {
    std::uint32_t interval;     // ticks; 0 for never
    std::uint32_t last;         // tick of the last one
    bool wanted;                // once, by MAV_CMD_REQUEST_MESSAGE
    std::uint32_t sent, bytes;  // so far
};

struct Telemetry {
    TelemetryStream stream[streams];
    int slow;                // part of the rate that a radio with a full buffer leaves, in percent
    std::uint32_t reported;  // tick of its last report
};

inline void begin(Telemetry& telemetry) {
    for (int k = 0; k < streams; ++k) telemetry.stream[k].interval = schedules[k].interval;
    telemetry.slow = 100;
}

/// Place of a message among the streams; -1 for none.
inline int stream_index(std::uint32_t id) {
    for (int k = 0; k < streams; ++k)
        if (schedules[k].id == id) return k;
    return -1;
}

/// Stream that is to be sent now; -1 for none.
inline int most_urgent(const Telemetry& telemetry, std::uint32_t tick) {
    int found = -1;
    float latest = 1.0f;
    for (int k = 0; k < streams; ++k) {
        const TelemetryStream& stream = telemetry.stream[k];
        if (stream.wanted) return k;
        if (stream.interval == 0) continue;
        const float late = float(tick - stream.last) / float(stream.interval);
        if (late < latest) continue;
        if (k == 0) return k;
        found = k, latest = late;
    }
    return found;
}

/// Make and send the message of a stream.
inline void send_stream(Outbox& out, Signing& signing, const Vehicle& vehicle, const Parser& parser, std::uint32_t id) {
    const Snapshot& now = snapshot(vehicle);
    switch (id) {
        case MAVLINK_MSG_ID_HEARTBEAT:
            return send(out, signing, heartbeat(now));
        case MAVLINK_MSG_ID_HYDRAULICS:
            return send(out, signing, hydraulics(now));
        case MAVLINK_MSG_ID_ATTITUDE:
            return send(out, signing, attitude(now));
        case MAVLINK_MSG_ID_LOCAL_POSITION_NED:
            return send(out, signing, local_position(now));
        case MAVLINK_MSG_ID_GAIT:
            return send(out, signing, gait(now));
        case MAVLINK_MSG_ID_PILOT:
            return send(out, signing, pilot_state(now));
        case MAVLINK_MSG_ID_SERVO_OUTPUT_RAW:
            return send(out, signing, servo_output(now));
        case MAVLINK_MSG_ID_SYS_STATUS:
            return send(out, signing, sys_status(now, parser.frames, parser.bad));
        case MAVLINK_MSG_ID_BATTERY_STATUS:
            return send(out, signing, battery_status(now));
        case MAVLINK_MSG_ID_MISSION_CURRENT:
            return send(out, signing, mission_current(vehicle));
        case MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            return send(out, signing, autopilot_version());
        case MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
            return send(out, signing, global_origin(vehicle));
        default:
            return;
    }
}

/// Send the most urgent message, if one is due.
inline bool telemeter(Telemetry& telemetry, Outbox& out, Signing& signing, const Vehicle& vehicle,
                      const Parser& parser) {
    const std::uint32_t tick = snapshot(vehicle).tick;
    const int k = most_urgent(telemetry, tick);
    if (k < 0) return false;
    TelemetryStream& stream = telemetry.stream[k];
    const std::uint32_t before = out.sent;
    send_stream(out, signing, vehicle, parser, schedules[k].id);
    // One that is late is not made up for: the next comes an interval after it was sent.
    const std::uint32_t due = stream.last + stream.interval;
    stream.last = stream.wanted || tick - due >= stream.interval ? tick : due;
    stream.wanted = false;
    ++stream.sent, stream.bytes += out.sent - before;
    return true;
}

inline constexpr std::uint32_t report_lasts = 1000;  // ticks

/// A radio that reports a buffer that fills up gets less, one whose buffer is empty more. RADIO_STATUS.txbuf in
/// percent.
inline void adapt(Telemetry& telemetry, int room, std::uint32_t tick) {
    if (room > 100) return;
    telemetry.reported = tick;
    const int change = room < 20 ? -20 : room < 50 ? -5 : room > 90 ? 5 : 0;
    const int slow = telemetry.slow + change;
    telemetry.slow = slow < 10 ? 10 : slow > 100 ? 100 : slow;
}

}  // namespace hypertuna::firmware
