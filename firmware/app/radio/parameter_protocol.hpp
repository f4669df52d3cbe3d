/// Parameter protocol: read, set, list (mavlink.io/en/services/parameter.html). The vehicle accepts or refuses a value:
/// vehicle.hpp, set_parameter.
#pragma once

#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

/// Names are sent in upper case, as clients expect, and accepted in either case.
inline char upper(char c) { return 'a' <= c && c <= 'z' ? char(c - 'a' + 'A') : c; }

inline bool same_name(const char* name, const char (&field)[16]) {
    for (int k = 0; k < 16; ++k) {
        if (upper(name[k]) != upper(field[k])) return false;
        if (name[k] == 0) return true;
    }
    return name[16] == 0;
}

inline int parameter_index(const Vehicle& vehicle, const char (&field)[16]) {
    for (int k = 0; k < parameter_count(vehicle); ++k)
        if (same_name(parameter(vehicle, k).name, field)) return k;
    return -1;
}

inline int parameter_named(const Vehicle& vehicle, const char* name) {
    char field[16];
    put_text(field, name);
    return parameter_index(vehicle, field);
}

inline mavlink_param_value_t parameter_value(const Vehicle& vehicle, int k) {
    mavlink_param_value_t m{};
    m.param_value = value(vehicle, k);
    m.param_count = std::uint16_t(parameter_count(vehicle)), m.param_index = std::uint16_t(k);
    put_text(m.param_id, parameter(vehicle, k).name);
    for (char& c : m.param_id) c = upper(c);
    m.param_type = MAV_PARAM_TYPE_REAL32;
    return m;
}

inline std::uint8_t error_of(Refusal refusal) {
    if (refusal == Refusal::unknown) return MAV_PARAM_ERROR_DOES_NOT_EXIST;
    const bool range = refusal == Refusal::out_of_range || refusal == Refusal::inconsistent;
    return std::uint8_t(range ? MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE : MAV_PARAM_ERROR_PERMISSION_DENIED);
}

inline void refuse_parameter(Radio& radio, const Vehicle& vehicle, Peer to, const char (&id)[16], int index,
                             Refusal refusal) {
    report_refusal(radio, vehicle, refusal);
    mavlink_param_error_t m{};
    m.param_index = std::int16_t(index), m.error = error_of(refusal);
    m.target_system = to.system, m.target_component = to.component;
    std::memcpy(m.param_id, id, sizeof m.param_id);
    if (has_room(radio.out)) reply(radio.out, m);
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_param_request_read_t& m) {
    const int k = m.param_index >= 0 ? m.param_index : parameter_index(vehicle, m.param_id);
    if (k < 0 || parameter_count(vehicle) <= k)
        return refuse_parameter(radio, vehicle, from, m.param_id, m.param_index, Refusal::unknown);
    reply(radio.out, parameter_value(vehicle, k));
}

/// Answer with the value on board, accepted or not; a refusal adds PARAM_ERROR.
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_param_set_t& m) {
    const int k = parameter_index(vehicle, m.param_id);
    if (k < 0) return refuse_parameter(radio, vehicle, from, m.param_id, -1, Refusal::unknown);
    const Refusal refusal =
        is_finite(m.param_value) ? set_parameter(vehicle, from, k, m.param_value) : Refusal::out_of_range;
    reply(radio.out, parameter_value(vehicle, k));
    if (refusal != Refusal::none) refuse_parameter(radio, vehicle, from, m.param_id, -1, refusal);
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer, const mavlink_param_request_list_t&) {
    radio.list_next = 0, radio.list_end = parameter_count(vehicle);
}

/// Send the next parameter of a list; false if there is none.
inline bool send_next_parameter(Radio& radio, const Vehicle& vehicle) {
    if (radio.list_end <= radio.list_next) return false;
    send(radio.out, radio.signing, parameter_value(vehicle, radio.list_next++));
    return true;
}

}  // namespace hypertuna::firmware
