/// Mission protocol: upload, download, clear. mavlink.io/en/services/mission.html
///
/// The robot requests item after item, and repeats a request that was not answered. The mission on board is replaced
/// when the last item has arrived and the whole mission is valid; a refused upload changes nothing.
#pragma once

#include "app/radio/mission_upload.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint32_t request_timeout = 150;  // ticks without the requested item
inline constexpr int max_tries = 8;

HYPERTUNA_NOINLINE inline void acknowledge_mission(Radio& radio, const Vehicle& vehicle, Peer to, std::uint8_t result,
                                                   std::uint8_t type) {
    mavlink_mission_ack_t m{};
    m.target_system = to.system, m.target_component = to.component, m.type = result, m.mission_type = type;
    if (result == MAV_MISSION_ACCEPTED) m.opaque_id = plan_number(vehicle, type);
    reply(radio.out, m);
}

inline std::uint8_t upload_type(const Upload& upload) {
    return std::uint8_t(upload.fence ? MAV_MISSION_TYPE_FENCE : MAV_MISSION_TYPE_MISSION);
}

inline void request_item(Radio& radio, std::uint32_t tick) {
    Upload& upload = radio.upload;
    mavlink_mission_request_int_t m{};
    m.seq = std::uint16_t(upload.next), m.mission_type = upload_type(upload);
    m.target_system = upload.system, m.target_component = upload.component;
    reply(radio.out, m);
    upload.requested_at = tick, ++upload.tries;
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
        case Refusal::too_fast:
        case Refusal::too_small:
        case Refusal::way_home:
            return MAV_MISSION_INVALID;
        case Refusal::too_many:
            return MAV_MISSION_NO_SPACE;
        case Refusal::no_mission:
            return MAV_MISSION_ERROR;
        case Refusal::not_taken:
        case Refusal::one_fence:
        case Refusal::no_rally:
            return MAV_MISSION_UNSUPPORTED;
        case Refusal::bad_frame:
            return MAV_MISSION_UNSUPPORTED_FRAME;
        default:
            return MAV_MISSION_DENIED;
    }
}

/// Clear the mission, the fence, or both.
inline void clear(Radio& radio, Vehicle& vehicle, Peer from, std::uint8_t type) {
    const bool all = type == MAV_MISSION_TYPE_ALL, rally = type == MAV_MISSION_TYPE_RALLY;  // there are no rally points
    const bool waypoints = all || type == MAV_MISSION_TYPE_MISSION, fence = all || type == MAV_MISSION_TYPE_FENCE;
    const Refusal refusal = waypoints || fence ? clear_mission(vehicle, from, waypoints, fence)
                            : rally            ? Refusal::none
                                               : Refusal::unknown;
    report_refusal(radio, vehicle, refusal);
    acknowledge_mission(radio, vehicle, from, mission_result(refusal), type);
}

inline char* append(char* at, const char* words) {
    while (*words != 0) *at++ = *words++;
    return at;
}
inline char* append(char* at, unsigned number) {
    if (number > 9) at = append(at, number / 10);
    *at = char('0' + number % 10);
    return at + 1;
}

/// Append a number below 1e7 with two decimals, without zeros at their end.
inline char* append(char* at, float number) {
    if (number < 0.0f) *at++ = '-';
    const unsigned hundredths = unsigned(abs(number) * 100.0f + 0.5f);
    at = append(at, hundredths / 100);
    if (hundredths % 100 == 0) return at;
    *at++ = '.', *at++ = char('0' + hundredths / 10 % 10);
    if (hundredths % 10 != 0) *at++ = char('0' + hundredths % 10);
    return at;
}

/// Report why an item, or (-1) the mission as a whole, is refused: number of the item; quantity, value and bound, or
/// the reason; and the command, where that is unsupported.
HYPERTUNA_NOINLINE inline void report_item(Radio& radio, int item, std::uint16_t command, const Breach& breach) {
    ++radio.refused;
    char text[120] = {};
    // A fence is checked with the waypoints of the mission on board.
    char* at = append(text, radio.upload.fence && 0 <= breach.waypoint ? "mission " : "");
    if (0 <= item) at = append(append(at, "item "), unsigned(item));
    if (breach.refusal == Refusal::not_taken) at = append(append(at, ", command "), unsigned(command));
    if (0 <= item) at = append(at, ": ");
    if (breach.quantity == nullptr) {
        append(at, sentence(breach.refusal));
    } else if (!(abs(breach.value) < 1e7f)) {
        append(append(at, breach.quantity), is_finite(breach.value) ? " is too large" : " is no number");
    } else {
        at = append(append(append(append(at, breach.quantity), " "), breach.value), breach.unit);
        append(append(at, breach.bound < breach.value ? ", max " : ", min "), breach.bound);
    }
    send_text(radio, MAV_SEVERITY_WARNING, text);
}

/// Begin an upload. A list without items clears the mission or the fence.
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_count_t& m) {
    Upload& upload = radio.upload;
    if (m.count == 0) return clear(radio, vehicle, from, m.mission_type);
    const bool fence = m.mission_type == MAV_MISSION_TYPE_FENCE;
    if (m.mission_type != MAV_MISSION_TYPE_MISSION && !fence) {
        report_refusal(radio, vehicle, Refusal::no_rally);
        return acknowledge_mission(radio, vehicle, from, MAV_MISSION_UNSUPPORTED, m.mission_type);
    }
    const bool other = upload.on && (upload.system != from.system || upload.component != from.component);
    if (other) return acknowledge_mission(radio, vehicle, from, MAV_MISSION_DENIED, m.mission_type);
    if (max_items < m.count) {
        report_item(radio, -1, 0, {Refusal::too_many, -1, "items", "", float(m.count), max_items});
        return acknowledge_mission(radio, vehicle, from, MAV_MISSION_NO_SPACE, m.mission_type);
    }
    const Refusal refusal = check(vehicle, Order::upload, from);
    if (refusal != Refusal::none) {
        report_refusal(radio, vehicle, refusal);
        return acknowledge_mission(radio, vehicle, from, mission_result(refusal), m.mission_type);
    }
    upload.on = true, upload.system = from.system, upload.component = from.component, upload.fence = fence;
    upload.count = m.count, upload.next = upload.tries = 0;
    begin_upload(upload, vehicle);
    request_item(radio, snapshot(vehicle).tick);
}

/// Number of a waypoint's item; -1 for none.
inline int item_of_waypoint(const MissionForm& form, int waypoint) {
    for (int k = 0, count = 0; k < form.items; ++k)
        if (form.item[k].kind == ItemKind::waypoint && count++ == waypoint) return k;
    return -1;
}

/// End an upload after its last item: check the whole mission, and keep it.
inline Breach end_upload(Upload& upload, Vehicle& vehicle, Peer from) {
    upload.on = false;
    if (!upload.fence && upload.mission.waypoints == 0) return {Refusal::no_mission};
    if (upload.fence && 0 < upload.mission.corners && upload.mission.corners < 3) return {Refusal::bad_fence};
    const Refusal refusal = check_end(upload);
    return refusal == Refusal::none ? set_mission(vehicle, from, upload.mission, &upload.form) : Breach{refusal};
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_item_int_t& m) {
    Upload& upload = radio.upload;
    if (upload.system != from.system || upload.component != from.component) return;
    const std::uint8_t type = upload_type(upload);
    // The last item came again, because its answer was lost.
    if (!upload.on && upload.next > 0 && m.seq == upload.next - 1)
        return acknowledge_mission(radio, vehicle, from, upload.result, type);
    if (!upload.on || m.seq != upload.next || m.mission_type != type) return;  // repeated, or out of order
    Breach breach = add_item(upload, vehicle, m);
    int item = m.seq;
    upload.tries = 0, ++upload.next;
    if (breach == Refusal::none) {
        if (upload.next < upload.count) return request_item(radio, snapshot(vehicle).tick);
        breach = end_upload(upload, vehicle, from);
        item = item_of_waypoint(upload.form, breach.waypoint);
    }
    if ((0 <= item && breach != Refusal::none) || breach.quantity != nullptr)
        report_item(radio, item, m.command, breach);
    else
        report_refusal(radio, vehicle, breach);
    upload.on = false, upload.result = mission_result(breach);
    acknowledge_mission(radio, vehicle, from, upload.result, type);
}

/// Repeat the request for an item that did not arrive, and give up after max_tries.
inline void await_item(Radio& radio, const Vehicle& vehicle) {
    Upload& upload = radio.upload;
    const std::uint32_t tick = snapshot(vehicle).tick;
    if (!upload.on || tick - upload.requested_at < request_timeout || !has_room(radio.out)) return;
    if (upload.tries < max_tries) return request_item(radio, tick);
    upload.on = false, upload.next = 0, ++radio.refused;
    acknowledge_mission(radio, vehicle, {upload.system, upload.component}, MAV_MISSION_OPERATION_CANCELLED,
                        upload_type(upload));
}

/// Number of items of a list; there are no rally points.
inline int list_length(const Vehicle& vehicle, std::uint8_t type) {
    if (type == MAV_MISSION_TYPE_MISSION) return vehicle.plan.form.items;
    return type == MAV_MISSION_TYPE_FENCE ? fence_items(vehicle) : 0;
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_list_t& m) {
    mavlink_mission_count_t out{};
    out.count = std::uint16_t(list_length(vehicle, m.mission_type)), out.mission_type = m.mission_type;
    out.target_system = from.system, out.target_component = from.component;
    out.opaque_id = plan_number(vehicle, m.mission_type);
    reply(radio.out, out);
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_int_t& m) {
    if (list_length(vehicle, m.mission_type) <= m.seq)
        return acknowledge_mission(radio, vehicle, from, MAV_MISSION_INVALID_SEQUENCE, m.mission_type);
    Item item{};
    if (m.mission_type == MAV_MISSION_TYPE_FENCE)
        item = fence_item(vehicle, m.seq);
    else
        visit_items(vehicle, [&](const Item& each) { item = each.seq == m.seq ? each : item; });
    item.target_system = from.system, item.target_component = from.component;
    reply(radio.out, item);
}
/// Handle the request of older clients; the answer is the same.
inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_mission_request_t& m) {
    mavlink_mission_request_int_t request{};
    request.seq = m.seq, request.mission_type = m.mission_type;
    handle(radio, vehicle, from, request);
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_clear_all_t& m) {
    clear(radio, vehicle, from, m.mission_type);
}

/// The ground cancels an upload.
inline void handle(Radio& radio, const Vehicle&, Peer from, const mavlink_mission_ack_t&) {
    Upload& upload = radio.upload;
    if (upload.on && upload.system == from.system && upload.component == from.component)
        upload.on = false, upload.next = 0;
}

}  // namespace hypertuna::firmware
