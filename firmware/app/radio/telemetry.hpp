/// Telemetry: the messages that the robot sends by itself, and which of them is next.
///
/// Each message has an interval: at boot that of the table, then what MAV_CMD_SET_MESSAGE_INTERVAL asks (commands.hpp).
/// Where the radio cannot carry all of them, every interval grows by the same factor: the message that is late by the
/// largest fraction of its interval goes first.
#pragma once

#include <concepts>

#include "app/radio/mission_download.hpp"
#include "app/radio/modes.hpp"
#include "app/radio/outbox.hpp"
#include "app/radio/positions.hpp"

namespace hypertuna::firmware {

/// A telemetry message: its id, its interval at boot, and how it is made and sent.
struct TelemetryMessage {
    std::uint32_t id;
    std::uint32_t interval;  // ticks of 10 ms; 0 for on request only
    bool placed;             // it needs the origin of coordinates
    void (*send)(Outbox&, Signing&, const Vehicle&, const Parser&);
};

/// Make a message of the vehicle, of its snapshot, or of the vehicle and the parser's counters.
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

/// All telemetry. The heartbeat is first: it is never late for another message. Position comes once in local
/// coordinates and once in degrees every two seconds. Whether there is a fix, and whether the robot is at the surface,
/// changes within seconds; home seldom changes. The rest is on request: its numbers are in other messages, too.
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

struct TelemetryStream {
    std::uint32_t interval;     // ticks; 0 for never
    std::uint32_t last;         // tick of the last message
    bool requested;             // once, by MAV_CMD_REQUEST_MESSAGE
    std::uint32_t sent, bytes;  // since boot
};

struct Telemetry {
    TelemetryStream stream[streams];
    int throttle;                   // share of the data rate left by a radio with a full buffer [percent]
    std::uint32_t radio_status_at;  // tick of the last RADIO_STATUS
};

inline void begin(Telemetry& telemetry) {
    for (int k = 0; k < streams; ++k) telemetry.stream[k].interval = telemetry_messages[k].interval;
    telemetry.throttle = 100;
}

/// Index of a message among the streams; -1 for none.
inline int stream_index(std::uint32_t id) {
    for (int k = 0; k < streams; ++k)
        if (telemetry_messages[k].id == id) return k;
    return -1;
}

/// Whether it is time for a heartbeat, which goes before any answer.
inline bool heartbeat_is_due(const Telemetry& telemetry, std::uint32_t tick) {
    const TelemetryStream& heart = telemetry.stream[0];
    return heart.interval <= tick - heart.last;
}

/// Stream to be sent now; -1 for none. placed: the origin of coordinates is known.
inline int max_urgent(const Telemetry& telemetry, std::uint32_t tick, bool placed) {
    int urgent = -1;
    float latest = 1.0f;
    for (int k = 0; k < streams; ++k) {
        const TelemetryStream& stream = telemetry.stream[k];
        if (telemetry_messages[k].placed && !placed) continue;
        if (stream.requested) return k;
        if (stream.interval == 0) continue;
        const float late = float(tick - stream.last) / float(stream.interval);
        if (late < latest) continue;
        if (k == 0) return k;
        urgent = k, latest = late;
    }
    return urgent;
}

/// Send the most urgent message; false if none is due.
inline bool send_telemetry(Telemetry& telemetry, Outbox& out, Signing& signing, const Vehicle& vehicle,
                           const Parser& parser) {
    const std::uint32_t tick = snapshot(vehicle).tick;
    const int k = max_urgent(telemetry, tick, origin(vehicle).known);
    if (k < 0) return false;
    TelemetryStream& stream = telemetry.stream[k];
    const std::uint32_t before = out.sent;
    telemetry_messages[k].send(out, signing, vehicle, parser);
    // A late message is not made up for: the next is due an interval after it was sent.
    const std::uint32_t due = stream.last + stream.interval;
    stream.last = stream.requested || tick - due >= stream.interval ? tick : due;
    stream.requested = false;
    ++stream.sent, stream.bytes += out.sent - before;
    return true;
}

inline constexpr std::uint32_t radio_status_lasts = 1000;  // ticks

/// Lower the data rate while the radio's buffer fills up, and raise it again. room: RADIO_STATUS.txbuf [percent].
inline void adapt(Telemetry& telemetry, int room, std::uint32_t tick) {
    if (room > 100) return;
    telemetry.radio_status_at = tick;
    const int change = room < 20 ? -20 : room < 50 ? -5 : room > 90 ? 5 : 0;
    const int throttle = telemetry.throttle + change;
    telemetry.throttle = throttle < 10 ? 10 : throttle > 100 ? 100 : throttle;
}

}  // namespace hypertuna::firmware
