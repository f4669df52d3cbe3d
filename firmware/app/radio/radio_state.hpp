/// State of the radio, and its functions for answers.
#pragma once

#include "app/radio/sequence.hpp"
#include "app/radio/telemetry.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint8_t own_component = 1;  // MAV_COMP_ID_AUTOPILOT1

/// A mission being uploaded item by item; the mission on board stays until the upload is complete.
struct Upload {
    bool on;
    std::uint8_t system, component;  // ids of the sender
    int count, next;                 // number of items; number of the next one
    std::uint8_t result;             // result of the last upload
    std::uint32_t requested_at;      // tick of the last request
    int tries;
    bool fence;     // the list is only a fence
    bool fenced;    // the list has items of a fence
    float corners;  // number of corners that its polygon names
    float speed;    // speed of the next waypoints
    MissionForm form;
    Waypoint<float> waypoint[max_waypoints];
    Corner<float> corner[max_corners];
    Mission<float> mission;
};

/// Address of an answer.
using Peer = Station;

/// Ids of frames by the modem itself, as in SiK radios and their successors: '3' and 'D'.
inline constexpr Peer modem{51, 68};

/// A file that is open, and the piece of it that is being sent.
struct Transfer {
    bool open, on;  // there is a session; a request is being answered
    Peer to;
    int file;
    std::uint8_t code;  // code of the request
    std::uint16_t sequence;
    int offset, limit;  // bytes: offset in the file; limit of a piece, 0 for as many as fit
};

/// Calibration of the gyroscope: ticks left; sums, minima and maxima of the counts.
struct GyroCalibration {
    Peer from;
    std::uint32_t left;
    float sum[3], low[3], high[3];
};

inline constexpr std::uint32_t restart_delay = 50;  // ticks until a restart, so that the answer is sent

struct Radio {
    Parser parser;
    Outbox out;
    Signing signing;
    Telemetry telemetry;
    Run run[max_runs];
    Upload upload;
    Transfer transfer;
    GyroCalibration gyro;
    int list_next, list_end;  // parameters still to be listed
    int mode_next, mode_end;  // modes still to be listed
    State reported_state;
    int reported_leg;
    std::uint32_t restart_at;  // tick; 0 for never
    Faults reported_faults;
    std::uint32_t fault_reported_at, refusal_reported_at;            // ticks of the last texts
    std::uint32_t commands, refused, replayed, not_signed, no_room;  // counts since boot
};

/// Copy a text into a field, which has no terminator if it is full.
template <std::size_t N>
void put_text(char (&field)[N], const char* text) {
    std::size_t k = 0;
    for (; k < N && text[k] != 0; ++k) field[k] = text[k];
    for (; k < N; ++k) field[k] = 0;
}

HYPERTUNA_NOINLINE inline void send_text(Radio& radio, std::uint8_t severity, const char* text) {
    mavlink_statustext_t m{};
    m.severity = severity;
    put_text(m.text, text);
    reply(radio.out, m);
}

/// Count a refusal that has no answer of its own, and report its reason at most every two seconds; a missing signature
/// every ten, since other stations' heartbeats may lack it for hours.
inline void report_rarely(Radio& radio, std::uint32_t tick, Refusal refusal) {
    ++radio.refused;
    const std::uint32_t pause = refusal == Refusal::not_signed ? 1000 : 200;
    if (tick - radio.refusal_reported_at < pause || !has_room(radio.out)) return;
    radio.refusal_reported_at = tick;
    send_text(radio, MAV_SEVERITY_WARNING, sentence(refusal));
}

/// Count a refusal and report its reason, unless the answer itself is enough: clients request much that a robot need
/// not support. One slot stays free for the answer. Where a fault is the reason, the text is the fault's own.
HYPERTUNA_NOINLINE inline void report_refusal(Radio& radio, const Vehicle& vehicle, Refusal refusal) {
    if (refusal == Refusal::none) return;
    ++radio.refused;
    if (refusal != Refusal::unknown && has_room(radio.out, 2))
        send_text(radio, MAV_SEVERITY_WARNING, sentence(vehicle, refusal));
}

inline std::uint8_t result_of(Refusal refusal) {
    switch (refusal) {
        case Refusal::none:
            return MAV_RESULT_ACCEPTED;
        case Refusal::unknown:
            return MAV_RESULT_UNSUPPORTED;
        case Refusal::int_only:
            return MAV_RESULT_COMMAND_INT_ONLY;
        case Refusal::armed:
        case Refusal::disarmed:
        case Refusal::not_ready:
        case Refusal::faulty:
        case Refusal::busy:
        case Refusal::no_mission:
        case Refusal::elsewhere:
        case Refusal::leaves_fence:
        case Refusal::robot_outside:
        case Refusal::not_placed:
        case Refusal::not_now:
        case Refusal::other_pilot:
        case Refusal::no_depth:
        case Refusal::submerged:
        case Refusal::not_centered:
            return MAV_RESULT_TEMPORARILY_REJECTED;
        default:
            return MAV_RESULT_DENIED;
    }
}

/// Acknowledge a command; result_param2 is the number of the refusal.
inline void acknowledge(Radio& radio, const Vehicle& vehicle, Peer to, std::uint16_t command, Refusal refusal) {
    report_refusal(radio, vehicle, refusal);
    mavlink_command_ack_t m{};
    m.command = command, m.result = result_of(refusal), m.result_param2 = int(refusal);
    m.target_system = to.system, m.target_component = to.component;
    reply(radio.out, m);
}

/// Whether a command is for this robot or for every robot. MANUAL_CONTROL is always for one robot.
template <class Message>
bool is_for(const Radio& radio, const Message& m) {
    const std::uint8_t own = radio.out.sender.system;
    if constexpr (requires { m.target; }) {
        return m.target == own;
    } else {
        bool addressed = m.target_system == own || m.target_system == 0;
        if constexpr (requires { m.target_component; })
            addressed = addressed && (m.target_component == own_component || m.target_component == 0);
        return addressed;
    }
}

}  // namespace hypertuna::firmware
