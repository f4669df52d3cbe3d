/// Tests of several stations: with equal ids, on the robot's own system, or with a newer dialect.
#include "radio_test.hpp"

static mavlink_heartbeat_t heartbeat() {
    mavlink_heartbeat_t m{};
    m.type = MAV_TYPE_GCS;
    return m;
}

static mavlink_command_long_t request(int message) { return command(MAV_CMD_REQUEST_MESSAGE, float(message)); }

/// Send as the station with these sequence numbers.
template <class Message>
static void say_as(Bench& bench, std::uint8_t& sequence, const Message& m, int ticks) {
    bench.ground.sequence = sequence;
    bench.say(m, ticks);
    sequence = bench.ground.sequence;
}

/// Two stations with equal ids, each with its heartbeats and requests: both are heard, with any sequence
/// numbers.
static void test_two_stations_with_equal_ids() {
    for (int lead = 1; lead < 256; lead += 6) {
        Bench bench;
        std::uint8_t one = 3, other = std::uint8_t(3 + lead);
        for (int second = 0; second < 3; ++second)
            say_as(bench, one, heartbeat(), 50), say_as(bench, other, heartbeat(), 50);
        const Radio& radio = bench.app.radio;
        const std::uint32_t before = radio.commands, refused = radio.replayed;
        for (int k = 0; k < 40; ++k) {
            say_as(bench, k % 3 == 0 ? one : other, request(MAVLINK_MSG_ID_AUTOPILOT_VERSION), 10);
            if (k % 7 == 0) say_as(bench, one, heartbeat(), 10);
        }
        CHECK(radio.commands - before == 40 && radio.replayed == refused);
    }
}

/// A repeated or late frame in one of two sequences is refused all the same.
static void test_repeated_frames_of_two_stations() {
    Bench bench;
    std::uint8_t one = 3, other = 20;
    for (int second = 0; second < 3; ++second)
        say_as(bench, one, heartbeat(), 50), say_as(bench, other, heartbeat(), 50);
    bench.ground.sequence = other;
    const Bytes early = bench.frame(request(MAVLINK_MSG_ID_AUTOPILOT_VERSION));
    const Bytes late = bench.frame(request(MAVLINK_MSG_ID_AUTOPILOT_VERSION));
    const Bytes last = bench.frame(request(MAVLINK_MSG_ID_AUTOPILOT_VERSION));
    const std::uint32_t before = bench.app.radio.commands;
    bench.hear(early), bench.run(10), bench.hear(last), bench.run(10);
    CHECK(bench.app.radio.commands == before + 2 && bench.app.radio.replayed == 0);
    bench.hear(early), bench.run(10), bench.hear(last), bench.run(10), bench.hear(late), bench.run(10);
    CHECK(bench.app.radio.commands == before + 2 && bench.app.radio.replayed == 3);
}

/// Two stations with the same ids number their frames independently. In any order of these numbers, disarming is heard.
static void test_disarm_of_two_stations() {
    for (const bool is_int : {false, true})
        for (int lead = 1; lead <= 60; lead += 7) {
            Bench bench;
            bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
            CHECK(snapshot(bench.vehicle()).armed());
            const std::uint8_t own = bench.ground.sequence;
            bench.ground.sequence = std::uint8_t(own + lead);
            bench.say(heartbeat(), 2);  // from the other station
            bench.ground.sequence = own;
            mavlink_command_int_t whole{};
            whole.command = MAV_CMD_COMPONENT_ARM_DISARM, whole.target_system = 1;
            if (is_int)
                bench.say(whole, 2);
            else
                bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0), 2);
            CHECK(!snapshot(bench.vehicle()).armed());
        }
}

/// A companion computer on the robot's system is heard; the robot's own frames, thrown back, are not.
static void test_companion() {
    Bench bench;
    bench.ground = {1, MAV_COMP_ID_ONBOARD_COMPUTER, 0};
    bench.say(request(MAVLINK_MSG_ID_AUTOPILOT_VERSION));
    CHECK(bench.app.radio.commands == 1 && last_answer(bench) == Refusal::none);
    bench.ground = {1, MAV_COMP_ID_AUTOPILOT1, 0};
    bench.say(request(MAVLINK_MSG_ID_AUTOPILOT_VERSION));
    CHECK(bench.app.radio.commands == 1);
}

/// A station whose dialect is newer sends extensions that are unknown here: the message counts without them.
static void test_unknown_extensions() {
    Bench bench;
    mavlink_command_long_t m = request(MAVLINK_MSG_ID_AUTOPILOT_VERSION);
    MessageKind newer = kind_of<mavlink_command_long_t>;
    std::uint8_t payload[sizeof m + 8];
    std::memset(payload, 7, sizeof payload);
    std::memcpy(payload, &m, sizeof m);
    newer.max_length = sizeof payload;
    Bytes bytes(max_frame);
    bytes.resize(std::size_t(write_frame(bytes.data(), newer, payload, bench.ground, false)));
    bench.hear(bytes), bench.run(10);
    CHECK(bench.app.radio.commands == 1 && last_answer(bench) == Refusal::none);
}

int main() {
    test_two_stations_with_equal_ids();
    test_repeated_frames_of_two_stations();
    test_disarm_of_two_stations();
    test_companion();
    test_unknown_extensions();
    return failures();
}
