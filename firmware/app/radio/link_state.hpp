/// All that the link remembers, and how it answers.
#pragma once

#include "app/radio/telemetry.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint8_t own_component = 1;  // MAV_COMP_ID_AUTOPILOT1
inline constexpr int most_sources = 4;
inline constexpr std::uint32_t silence = 200;  // ticks after which a source may begin to count anew
inline constexpr int window = 64;              // frames: one that is up to so many older than the last is old

/// Somebody who gives orders, and the last frame that was heard.
struct Source {
    std::uint8_t system, component, sequence;
    bool used;
    std::uint32_t tick;
};

/// A mission that comes in item by item; the one on board stays until this one is whole.
struct Upload {
    bool on;
    std::uint8_t system, component;  // of the sender
    int count, next;                 // items
    std::uint8_t result;             // of the last that ended
    std::uint32_t asked;             // tick of the last request
    int tries;
    float speed;  // of the waypoints to come
    Waypoint<float> waypoint[most_waypoints];
    Corner<float> corner[most_corners];
    Mission<float> mission;
};

struct Link {
    Parser parser;
    Outbox out;
    Signing signing;
    Telemetry telemetry;
    Source source[most_sources];
    Upload upload;
    int list_next, list_end;  // parameters that are still to be told
    Faults told_faults;
    std::uint32_t told, told_refusal;                               // ticks of the last texts
    std::uint32_t orders, refused, replayed, not_signed, no_place;  // so far
};

/// Somebody to answer to.
struct Peer {
    std::uint8_t system, component;
};

/// Copy a text into a field that has no terminator where it is full.
template <std::size_t N>
void put_text(char (&field)[N], const char* text) {
    std::size_t k = 0;
    for (; k < N && text[k] != 0; ++k) field[k] = text[k];
    for (; k < N; ++k) field[k] = 0;
}

inline void tell(Link& link, std::uint8_t severity, const char* text) {
    mavlink_statustext_t m{};
    m.severity = severity;
    put_text(m.text, text);
    reply(link.out, m);
}

/// Why an order was not even read, or one of many was not followed: at most every two seconds.
inline void tell_rarely(Link& link, std::uint32_t tick, Refusal refusal) {
    ++link.refused;
    if (tick - link.told_refusal < 200 || !has_room(link.out)) return;
    link.told_refusal = tick;
    tell(link, MAV_SEVERITY_WARNING, sentence(refusal));
}

/// Count a refusal and say why, unless its answer says it all: clients ask for much that a robot need not know. The
/// text keeps one place free for the answer proper.
inline void tell_refusal(Link& link, Refusal refusal) {
    if (refusal == Refusal::none) return;
    ++link.refused;
    if (refusal != Refusal::unknown && has_room(link.out, 2)) tell(link, MAV_SEVERITY_WARNING, sentence(refusal));
}

inline std::uint8_t result_of(Refusal refusal) {
    switch (refusal) {
        case Refusal::none:
            return MAV_RESULT_ACCEPTED;
        case Refusal::unknown:
            return MAV_RESULT_UNSUPPORTED;
        case Refusal::armed:
        case Refusal::disarmed:
        case Refusal::not_ready:
        case Refusal::faulty:
        case Refusal::busy:
        case Refusal::no_mission:
        case Refusal::elsewhere:
            return MAV_RESULT_TEMPORARILY_REJECTED;
        default:
            return MAV_RESULT_DENIED;
    }
}

/// Acknowledge a command; result_param2 is the refusal's number.
inline void acknowledge(Link& link, Peer to, std::uint16_t command, Refusal refusal) {
    tell_refusal(link, refusal);
    mavlink_command_ack_t m{};
    m.command = command, m.result = result_of(refusal), m.result_param2 = int(refusal);
    m.target_system = to.system, m.target_component = to.component;
    reply(link.out, m);
}

/// Whether a frame is newer than the last one of its source. Radios repeat and overtake; an old order is not followed.
inline bool is_fresh(Link& link, const Frame& frame, std::uint32_t tick) {
    Source* place = nullptr;
    for (Source& source : link.source) {
        if (source.used && source.system == frame.system && source.component == frame.component) {
            place = &source;
            break;
        }
        // A new source takes a free place, or that of whoever was silent for longest.
        if (place == nullptr || !source.used || (place->used && tick - source.tick > tick - place->tick))
            if (place == nullptr || place->used) place = &source;
    }
    const bool known = place->used && place->system == frame.system && place->component == frame.component;
    const int behind = std::uint8_t(place->sequence - frame.sequence);
    if (known && tick - place->tick <= silence && behind < window) return false;
    *place = {frame.system, frame.component, frame.sequence, true, tick};
    return true;
}

/// Whether an order is for this robot, or for every one.
template <class Message>
bool is_for(const Link& link, const Message& m) {
    const std::uint8_t own = link.out.sender.system;
    return (m.target_system == own || m.target_system == 0) &&
           (m.target_component == own_component || m.target_component == 0);
}

/// Follow an order, if it is for this robot.
template <class Message, class Follow>
void follow_message(Link& link, const Message& m, const Follow& follow) {
    if (!is_for(link, m)) return;
    ++link.orders;
    follow(m);
}

/// Read an order and follow it, if it is for this robot.
template <class Message, class Follow>
void follow_order(Link& link, const Frame& frame, const Follow& follow) {
    follow_message(link, message_of<Message>(frame), follow);
}

}  // namespace hypertuna::firmware
