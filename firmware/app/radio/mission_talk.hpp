/// Missions over the radio, up and down. mavlink.io/en/services/mission.html
///
/// The robot asks for one item after another, and again where none comes. The mission on board is replaced when the
/// last one is in and the whole is accepted; until then, and after any refusal, it is what it was.
#pragma once

#include "app/radio/mission_items.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint32_t ask_again = 150;  // ticks without the item that was asked for
inline constexpr int most_tries = 8;

inline void acknowledge_mission(Link& link, Peer to, std::uint8_t result) {
    mavlink_mission_ack_t m{};
    m.target_system = to.system, m.target_component = to.component, m.type = result;
    reply(link.out, m);
}

inline void ask_item(Link& link, std::uint32_t tick) {
    Upload& upload = link.upload;
    mavlink_mission_request_int_t m{};
    m.seq = std::uint16_t(upload.next);
    m.target_system = upload.system, m.target_component = upload.component;
    reply(link.out, m);
    upload.asked = tick, ++upload.tries;
}

/// Missions alone: fences and rally points of their own lists are not kept.
template <class Message>
bool is_mission(Link& link, Peer from, const Message& m) {
    if (m.mission_type == MAV_MISSION_TYPE_MISSION) return true;
    acknowledge_mission(link, from, MAV_MISSION_UNSUPPORTED);
    return false;
}

inline void on_mission_count(Link& link, const Vehicle& vehicle, Peer from, const mavlink_mission_count_t& m) {
    Upload& upload = link.upload;
    if (!is_mission(link, from, m)) return;
    if (upload.on && (upload.system != from.system || upload.component != from.component))
        return acknowledge_mission(link, from, MAV_MISSION_DENIED);
    if (m.count == 0 || most_items < m.count)
        return acknowledge_mission(link, from, m.count == 0 ? MAV_MISSION_ERROR : MAV_MISSION_NO_SPACE);
    upload.on = true, upload.system = from.system, upload.component = from.component;
    upload.count = m.count, upload.next = upload.tries = 0;
    begin_mission(upload, snapshot(vehicle));
    ask_item(link, snapshot(vehicle).tick);
}

inline std::uint8_t mission_result(Refusal refusal) {
    switch (refusal) {
        case Refusal::none:
            return MAV_MISSION_ACCEPTED;
        case Refusal::out_of_range:
        case Refusal::inconsistent:
            return MAV_MISSION_INVALID;
        case Refusal::too_many:
            return MAV_MISSION_NO_SPACE;
        case Refusal::no_mission:
            return MAV_MISSION_ERROR;
        default:
            return MAV_MISSION_DENIED;
    }
}

inline void on_mission_item(Link& link, Vehicle& vehicle, Peer from, const mavlink_mission_item_int_t& m) {
    Upload& upload = link.upload;
    if (upload.system != from.system || upload.component != from.component) return;
    // The one that ended it, once more: its answer was lost.
    if (!upload.on && upload.next > 0 && m.seq == upload.next - 1)
        return acknowledge_mission(link, from, upload.result);
    if (!upload.on || m.seq != upload.next) return;  // came twice, or is not what was asked for
    upload.result = take_item(upload, vehicle, m);
    upload.tries = 0, ++upload.next;
    if (upload.result != MAV_MISSION_ACCEPTED) {
        upload.on = false, ++link.refused;
        return acknowledge_mission(link, from, upload.result);
    }
    if (upload.next < upload.count) return ask_item(link, snapshot(vehicle).tick);
    upload.on = false;
    const Refusal refusal = upload.mission.waypoints == 0 ? Refusal::no_mission : set_mission(vehicle, upload.mission);
    tell_refusal(link, refusal);
    upload.result = mission_result(refusal);
    acknowledge_mission(link, from, upload.result);
}

/// Ask for the item once more where it did not come, and give up at last.
inline void wait_for_item(Link& link, std::uint32_t tick) {
    Upload& upload = link.upload;
    if (!upload.on || tick - upload.asked < ask_again || !has_room(link.out)) return;
    if (upload.tries < most_tries) return ask_item(link, tick);
    upload.on = false, upload.next = 0, ++link.refused;
    acknowledge_mission(link, {upload.system, upload.component}, MAV_MISSION_OPERATION_CANCELLED);
}

inline void on_mission_request_list(Link& link, const Vehicle& vehicle, Peer from,
                                    const mavlink_mission_request_list_t& m) {
    if (!is_mission(link, from, m)) return;
    mavlink_mission_count_t out{};
    out.count = std::uint16_t(visit_items(mission(vehicle), [](const auto&) {}));
    out.target_system = from.system, out.target_component = from.component;
    reply(link.out, out);
}

template <class Message>
void on_mission_request(Link& link, const Vehicle& vehicle, Peer from, const Message& m) {
    if (!is_mission(link, from, m)) return;
    mavlink_mission_item_int_t item{};
    const int count = visit_items(mission(vehicle), [&](const auto& each) {
        if (each.seq == m.seq) item = each;
    });
    if (count <= m.seq) return acknowledge_mission(link, from, MAV_MISSION_INVALID_SEQUENCE);
    item.target_system = from.system, item.target_component = from.component;
    reply(link.out, item);
}

inline void on_mission_clear(Link& link, Vehicle& vehicle, Peer from, const mavlink_mission_clear_all_t& m) {
    const bool all = m.mission_type == MAV_MISSION_TYPE_ALL;
    if (!all && !is_mission(link, from, m)) return;
    const Refusal refusal = clear_mission(vehicle);
    tell_refusal(link, refusal);
    acknowledge_mission(link, from, mission_result(refusal));
}

/// The ground breaks an upload off.
inline void on_mission_ack(Link& link, Peer from, const mavlink_mission_ack_t&) {
    Upload& upload = link.upload;
    if (upload.on && upload.system == from.system && upload.component == from.component)
        upload.on = false, upload.next = 0;
}

inline void on_mission_order(Link& link, Vehicle& vehicle, const Frame& frame) {
    const Peer from{frame.system, frame.component};
    const auto request = [&](const auto& m) { on_mission_request(link, vehicle, from, m); };
    switch (frame.id) {
        case MAVLINK_MSG_ID_MISSION_COUNT:
            return follow_order<mavlink_mission_count_t>(
                link, frame, [&](const auto& m) { on_mission_count(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_MISSION_ITEM_INT:
            return follow_order<mavlink_mission_item_int_t>(
                link, frame, [&](const auto& m) { on_mission_item(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_MISSION_REQUEST_LIST:
            return follow_order<mavlink_mission_request_list_t>(
                link, frame, [&](const auto& m) { on_mission_request_list(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_MISSION_REQUEST_INT:
            return follow_order<mavlink_mission_request_int_t>(link, frame, request);
        case MAVLINK_MSG_ID_MISSION_REQUEST:
            return follow_order<mavlink_mission_request_t>(link, frame, request);
        case MAVLINK_MSG_ID_MISSION_CLEAR_ALL:
            return follow_order<mavlink_mission_clear_all_t>(
                link, frame, [&](const auto& m) { on_mission_clear(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_MISSION_ACK:
            return follow_order<mavlink_mission_ack_t>(link, frame,
                                                       [&](const auto& m) { on_mission_ack(link, from, m); });
        default:
            return;
    }
}

}  // namespace hypertuna::firmware
