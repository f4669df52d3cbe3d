/// Telemetry: chooses the next of the messages that the robot sends by itself (messages.hpp).
///
/// Each message has an interval: at boot that of the table, then the one that MAV_CMD_SET_MESSAGE_INTERVAL sets
/// (commands.hpp). Where the radio cannot carry all messages, every interval grows by the same factor: the message that
/// is late by the largest fraction of its interval goes first.
#pragma once

#include "app/radio/messages.hpp"

namespace hypertuna::firmware {

struct TelemetryStream {
    std::uint32_t interval;     // ticks; 0 for never
    std::uint32_t last;         // tick of the last message
    bool requested;             // whether MAV_CMD_REQUEST_MESSAGE asked to send it once
    std::uint32_t sent, bytes;  // messages and bytes since boot
};

struct Telemetry {
    TelemetryStream stream[streams];
    float allowance;                // bytes that telemetry and lists may use now
    bool sent;                      // something was sent since the last RADIO_STATUS
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

/// Ticks between two beacons of a robot that hears no station and has stopped, after a failsafe or because the pilot
/// holds, to save its battery; else 0.
inline std::uint32_t beacon_ticks(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const bool stopped = is_guided(now.state) ? now.mode == Mode::hold : Answer::home <= now.answer;
    if (!stopped || !now.faults.has(Fault::link_lost)) return 0;
    return std::uint32_t(limits(vehicle).beacon_interval / pilot(vehicle)->controller.tick);
}

/// Stream to be sent now; -1 for none. `placed`: the place on the map is known; at least `least` ticks pass between two
/// messages of a kind, except heartbeats.
inline int max_urgent(const Telemetry& telemetry, std::uint32_t tick, bool placed, std::uint32_t least) {
    int urgent = -1;
    float latest = 1.0f;
    for (int k = 0; k < streams; ++k) {
        const TelemetryStream& stream = telemetry.stream[k];
        if (telemetry_messages[k].placed && !placed) continue;
        if (stream.requested) return k;
        if (stream.interval == 0) continue;
        const std::uint32_t interval = k == 0 || least < stream.interval ? stream.interval : least;
        const float late = float(tick - stream.last) / float(interval);
        if (late < latest) continue;
        if (k == 0) return k;
        urgent = k, latest = late;
    }
    return urgent;
}

/// Send the most urgent message; false if none is due.
inline bool send_telemetry(Telemetry& telemetry, Outbox& out, Signing& signing, const Vehicle& vehicle,
                           const Parser& parser) {
    const std::uint32_t tick = snapshot(vehicle).tick, least = beacon_ticks(vehicle);
    const int k = max_urgent(telemetry, tick, is_placed(vehicle), least);
    if (k < 0) return false;
    TelemetryStream& stream = telemetry.stream[k];
    const std::uint32_t before = out.sent;
    telemetry_messages[k].send(out, signing, vehicle, parser);
    // Messages that were missed, or were left out between beacons, are not sent later: the next is due an interval
    // after this one.
    const std::uint32_t due = stream.last + stream.interval;
    stream.last = stream.requested || 0 < least || tick - due >= stream.interval ? tick : due;
    stream.requested = false;
    ++stream.sent, stream.bytes += out.sent - before;
    return true;
}

inline constexpr std::uint32_t radio_status_lasts = 1000;  // ticks for which a RADIO_STATUS counts

/// Lower the telemetry's rate while the radio's buffer fills up, and raise it again. `room` is RADIO_STATUS.txbuf
/// [percent], which says something about telemetry only if some was sent since the last one.
inline void adapt(Telemetry& telemetry, int room, std::uint32_t tick) {
    if (room > 100 || !telemetry.sent) return;
    telemetry.radio_status_at = tick, telemetry.sent = false;
    const int change = room < 20 ? -20 : room < 50 ? -5 : room > 90 ? 5 : 0;
    const int throttle = telemetry.throttle + change;
    telemetry.throttle = throttle < 10 ? 10 : throttle > 100 ? 100 : throttle;
}

}  // namespace hypertuna::firmware
