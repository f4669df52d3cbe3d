/// A hostile station: valid frames of every message that the robot accepts, whose fields no honest one sends, in the
/// sequences of the services.
#pragma once

#include <random>

#include "radio_test.hpp"

struct Chance {
    std::mt19937_64 bits;

    std::size_t below(std::size_t count) { return bits() % count; }
    template <class T, std::size_t N>
    T any_of(const T (&values)[N]) {
        return values[below(N)];
    }
    float number() {
        constexpr float odd[] = {0,          -0.0f,  1,      -1,  0.5f, 2.5f,  65535,         65536,          3e9f,
                                 1e38f,      -1e38f, 1e-40f, 255, 256,  1e10f, 2147483648.0f, -2147483648.0f, HUGE_VALF,
                                 -HUGE_VALF, NAN};
        return below(3) == 0 ? float(below(100)) - 20.0f : any_of(odd);
    }
};

/// A message whose bytes are odd numbers, extremes or chance.
template <class Message>
Message hostile(Chance& chance) {
    Message m{};
    std::uint8_t bytes[sizeof m];
    const std::size_t kind = chance.below(4);
    for (std::size_t k = 0; k < sizeof m; ++k) {
        bytes[k] = std::uint8_t(kind == 0 ? 0 : kind == 1 ? 255 * chance.below(2) : chance.bits());
        const float odd = chance.number();
        if constexpr (sizeof m > 3)
            if (kind == 3 && k % 4 == 3) std::memcpy(bytes + k - 3, &odd, 4);
    }
    std::memcpy(static_cast<void*>(&m), bytes, sizeof m);
    return m;
}

/// Set the fields that a message needs to pass its first check, most of the time.
template <class Message>
void shape(Message&, Chance&, const Vehicle&) {}
template <class Command>
void shape_command(Command& m, Chance& chance) {
    constexpr int commands[] = {MAV_CMD_COMPONENT_ARM_DISARM,
                                MAV_CMD_DO_SET_MODE,
                                MAV_CMD_DO_SET_STANDARD_MODE,
                                MAV_CMD_MISSION_START,
                                MAV_CMD_DO_PAUSE_CONTINUE,
                                MAV_CMD_DO_SET_MISSION_CURRENT,
                                MAV_CMD_NAV_RETURN_TO_LAUNCH,
                                MAV_CMD_NAV_LAND,
                                HYPERTUNA_CMD_GAIT,
                                MAV_CMD_SET_MESSAGE_INTERVAL,
                                MAV_CMD_GET_MESSAGE_INTERVAL,
                                MAV_CMD_REQUEST_MESSAGE,
                                MAV_CMD_RUN_PREARM_CHECKS,
                                MAV_CMD_PREFLIGHT_CALIBRATION,
                                MAV_CMD_DO_SET_HOME,
                                MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES,
                                MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN};
    m.command = std::uint16_t(chance.any_of(commands));
    if (chance.below(2)) m.param1 = float(chance.below(2));
    if (chance.below(3) == 0) m.param1 = float(telemetry_messages[chance.below(streams)].id);
    if (m.command == MAV_CMD_DO_SET_MODE && chance.below(2))
        m.param1 = 1, m.param2 = float(mode_base + chance.below(9));
}
inline void shape(mavlink_command_long_t& m, Chance& chance, const Vehicle&) { shape_command(m, chance); }
inline void shape(mavlink_command_int_t& m, Chance& chance, const Vehicle&) { shape_command(m, chance); }
inline void shape(mavlink_param_set_t& m, Chance& chance, const Vehicle& vehicle) {
    const ParameterInfo& info = parameter(vehicle, int(chance.below(std::size_t(parameter_count(vehicle)))));
    put_text(m.param_id, info.name);
    m.param_type = MAV_PARAM_TYPE_REAL32;
    const float values[] = {info.low, info.high, info.standard, chance.number(), (info.low + info.high) / 2};
    m.param_value = chance.any_of(values);
}
inline void shape(mavlink_param_request_read_t& m, Chance& chance, const Vehicle& vehicle) {
    m.param_index = std::int16_t(chance.below(4) ? std::int64_t(chance.below(200)) - 2 : -32768);
    put_text(m.param_id, parameter(vehicle, 0).name);
}
inline void shape(mavlink_file_transfer_protocol_t& m, Chance& chance, const Vehicle& vehicle) {
    std::uint8_t (&p)[sizeof m.payload] = m.payload;
    p[2] = std::uint8_t(chance.below(3) ? 0 : chance.bits()), p[3] = std::uint8_t(chance.below(17));
    p[4] = std::uint8_t(chance.below(2) ? 80 : chance.bits());
    if (chance.below(2)) std::memset(p + 8, int(chance.below(2) * 255), 4);
    if (vehicle.robot->files == 0 || chance.below(3) == 0) return;
    const char* const name = vehicle.robot->file[chance.below(std::size_t(vehicle.robot->files))].name;
    std::memcpy(p + 12, name, std::min(strlen(name) + 1, sizeof m.payload - 12)), p[4] = std::uint8_t(strlen(name));
}
inline void shape(mavlink_setup_signing_t& m, Chance& chance, const Vehicle&) {
    if (chance.below(2)) std::memset(m.secret_key, int(chance.below(2)), sizeof m.secret_key);
    if (chance.below(2)) m.initial_timestamp = chance.bits() >> (16 + chance.below(48));
}

/// Send a hostile message of the kind at this index of the dialect, if the robot accepts it.
template <class... Messages>
void send_hostile(MessageList<Messages...>, Bench& bench, Chance& chance, std::size_t pick) {
    std::size_t k = 0;
    const auto visit = [&]<class Message>() {
        if constexpr (Notice<Message> || Directed<Message>) {
            if (k++ % 64 != pick) return;
            Message m = hostile<Message>(chance);
            shape(m, chance, bench.vehicle());
            if constexpr (requires { m.target_system; })
                if (chance.below(8)) m.target_system = std::uint8_t(chance.below(4) ? 1 : 0);
            if constexpr (requires { m.target_component; })
                if (chance.below(8)) m.target_component = std::uint8_t(chance.below(2));
            if constexpr (requires { m.target; }) m.target = 1;
            bench.hear(bench.frame(m));
        }
    };
    (visit.template operator()<Messages>(), ...);
}

/// Upload a list, right or wrong: items of the box with odd fields, some missing, repeated or out of order.
inline void send_mission(Bench& bench, Chance& chance) {
    auto items = box();
    const std::uint8_t type = std::uint8_t(chance.below(8) ? chance.below(2) : chance.bits());
    mavlink_mission_count_t count{};
    count.count = std::uint16_t(chance.below(6) ? items.size() : chance.bits());
    count.target_system = 1, count.mission_type = type;
    bench.say(count, int(chance.below(4)));
    for (std::size_t k = 0; k < items.size(); ++k) {
        mavlink_mission_item_int_t& m = items[chance.below(8) ? k : chance.below(items.size())];
        if (chance.below(16) == 0) m = hostile<mavlink_mission_item_int_t>(chance);
        float* const fields[] = {&m.param1, &m.param2, &m.param3, &m.param4, &m.z};
        if (chance.below(8) == 0) *chance.any_of(fields) = chance.number();
        if (chance.below(16) == 0) m.x = std::int32_t(chance.bits()), m.frame = std::uint8_t(chance.below(22));
        m.seq = std::uint16_t(chance.below(16) ? k : chance.bits()), m.target_system = 1, m.mission_type = type;
        bench.say(m, int(chance.below(4)));
    }
}
