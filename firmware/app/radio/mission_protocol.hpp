/// Mission protocol: upload, download, clear. mavlink.io/en/services/mission.html
///
/// The robot requests item after item, and repeats a request without an answer. The mission on board is replaced when
/// the last item has arrived and the whole mission is valid; a refused upload changes nothing.
#pragma once

#include "app/radio/mission_upload.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint32_t request_timeout = 150;  // ticks without the requested item
inline constexpr int max_tries = 8;

inline void acknowledge_mission(Radio& radio, Peer to, std::uint8_t result) {
    mavlink_mission_ack_t m{};
    m.target_system = to.system, m.target_component = to.component, m.type = result;
    reply(radio.out, m);
}

inline void request_item(Radio& radio, std::uint32_t tick) {
    Upload& upload = radio.upload;
    mavlink_mission_request_int_t m{};
    m.seq = std::uint16_t(upload.next);
    m.target_system = upload.system, m.target_component = upload.component;
    reply(radio.out, m);
    upload.requested_at = tick, ++upload.tries;
}

/// Whether a message is about the mission: separate lists of fences and rally points are not supported.
template <class Message>
bool is_mission(Radio& radio, Peer from, const Message& m) {
    if (m.mission_type == MAV_MISSION_TYPE_MISSION) return true;
    acknowledge_mission(radio, from, MAV_MISSION_UNSUPPORTED);
    return false;
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_count_t& m) {
    Upload& upload = radio.upload;
    if (!is_mission(radio, from, m)) return;
    if (upload.on && (upload.system != from.system || upload.component != from.component))
        return acknowledge_mission(radio, from, MAV_MISSION_DENIED);
    if (m.count == 0 || max_items < m.count)
        return acknowledge_mission(radio, from, m.count == 0 ? MAV_MISSION_ERROR : MAV_MISSION_NO_SPACE);
    upload.on = true, upload.system = from.system, upload.component = from.component;
    upload.count = m.count, upload.next = upload.tries = 0;
    begin_mission(upload, snapshot(vehicle));
    request_item(radio, snapshot(vehicle).tick);
}

inline std::uint8_t mission_result(Refusal refusal) {
    switch (refusal) {
        case Refusal::none:
            return MAV_MISSION_ACCEPTED;
        case Refusal::out_of_range:
        case Refusal::inconsistent:
        case Refusal::bad_fence:
        case Refusal::outside_fence:
        case Refusal::leaves_fence:
        case Refusal::too_deep:
            return MAV_MISSION_INVALID;
        case Refusal::too_many:
            return MAV_MISSION_NO_SPACE;
        case Refusal::no_mission:
            return MAV_MISSION_ERROR;
        default:
            return MAV_MISSION_DENIED;
    }
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_item_int_t& m) {
    Upload& upload = radio.upload;
    if (upload.system != from.system || upload.component != from.component) return;
    // The last item again: its answer was lost.
    if (!upload.on && upload.next > 0 && m.seq == upload.next - 1)
        return acknowledge_mission(radio, from, upload.result);
    if (!upload.on || m.seq != upload.next) return;  // a repeated item, or one out of order
    upload.result = add_item(upload, vehicle, m);
    upload.tries = 0, ++upload.next;
    if (upload.result != MAV_MISSION_ACCEPTED) {
        upload.on = false, ++radio.refused;
        return acknowledge_mission(radio, from, upload.result);
    }
    if (upload.next < upload.count) return request_item(radio, snapshot(vehicle).tick);
    upload.on = false;
    const Refusal refusal =
        upload.mission.waypoints == 0 ? Refusal::no_mission : set_mission(vehicle, from, upload.mission);
    report_refusal(radio, refusal);
    upload.result = mission_result(refusal);
    acknowledge_mission(radio, from, upload.result);
}

/// Repeat the request for an item that did not arrive, and give up after max_tries.
inline void await_item(Radio& radio, std::uint32_t tick) {
    Upload& upload = radio.upload;
    if (!upload.on || tick - upload.requested_at < request_timeout || !has_room(radio.out)) return;
    if (upload.tries < max_tries) return request_item(radio, tick);
    upload.on = false, upload.next = 0, ++radio.refused;
    acknowledge_mission(radio, {upload.system, upload.component}, MAV_MISSION_OPERATION_CANCELLED);
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_list_t& m) {
    if (!is_mission(radio, from, m)) return;
    mavlink_mission_count_t out{};
    out.count = std::uint16_t(visit_items(mission(vehicle), [](const auto&) {}));
    out.target_system = from.system, out.target_component = from.component;
    reply(radio.out, out);
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_int_t& m) {
    if (!is_mission(radio, from, m)) return;
    mavlink_mission_item_int_t item{};
    const int count = visit_items(mission(vehicle), [&](const auto& each) {
        if (each.seq == m.seq) item = each;
    });
    if (count <= m.seq) return acknowledge_mission(radio, from, MAV_MISSION_INVALID_SEQUENCE);
    item.target_system = from.system, item.target_component = from.component;
    reply(radio.out, item);
}
/// The request of older clients: the answer is the same.
inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_t& m) {
    mavlink_mission_request_int_t request{};
    request.seq = m.seq, request.mission_type = m.mission_type;
    handle(radio, vehicle, from, request);
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_clear_all_t& m) {
    const bool all = m.mission_type == MAV_MISSION_TYPE_ALL;
    if (!all && !is_mission(radio, from, m)) return;
    const Refusal refusal = clear_mission(vehicle, from);
    report_refusal(radio, refusal);
    acknowledge_mission(radio, from, mission_result(refusal));
}

/// The ground cancels an upload.
inline void handle(Radio& radio, const Vehicle&, Peer from, const mavlink_mission_ack_t&) {
    Upload& upload = radio.upload;
    if (upload.on && upload.system == from.system && upload.component == from.component)
        upload.on = false, upload.next = 0;
}

}  // namespace hypertuna::firmware
