/// Tests of a crowded link: a flood of frames delays no safety order, with or without space for the answer.
#include "radio_test.hpp"

/// A signed robot, armed, and its ground station; another sender fills the link with frames.
struct Flooded : Bench {
    Bytes waiting{};  // bytes on a line to the robot
    int line;         // bytes per tick that the line carries; 0 for an unlimited line
    Bytes junk;       // a frame of the flood
    explicit Flooded(const Bytes& frame, int rate = 0) : line(rate), junk(frame) {
        mavlink_setup_signing_t setup{};
        setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = 1'000'000'000;
        say(setup);
        begin_signing(key, setup.secret_key, setup.initial_timestamp);
        say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
        CHECK(app.radio.signing.on && snapshot(vehicle()).armed());
        app.vehicle.home = {100, 100}, board.depth = 1;  // home and surface take their time
        run(100);
    }
    /// A tick under the flood: one frame of it, or as many as keep the line busy.
    void endure() {
        if (line == 0) hear(junk);
        while (int(waiting.size()) < line) waiting.insert(waiting.end(), junk.begin(), junk.end());
        hear({waiting.begin(), waiting.begin() + line});
        waiting.erase(waiting.begin(), waiting.begin() + line);
        run(1);
    }
    /// Send something once amid the flood; returns whether the vehicle enters a state within a second.
    template <class Message>
    bool brings(const Message& m, State state) {
        const Bytes bytes = frame(m);
        if (line == 0) hear(bytes);
        if (line != 0) waiting.insert(waiting.end(), bytes.begin(), bytes.end());
        bool entered = false;
        for (int k = 0; k < 100; ++k) {
            endure();
            entered = entered || snapshot(vehicle()).state == state;
        }
        return entered;
    }
};

/// A frame that anybody can send: without a signature, even if it says that one follows.
template <class Message>
Bytes unsigned_frame(const Message& m, Sender from, bool torn = false) {
    Bytes bytes(max_frame);
    bytes.resize(std::size_t(
        write_frame(bytes.data(), kind_of<Message>, reinterpret_cast<const std::uint8_t*>(&m), from, torn)));
    return bytes;
}

static constexpr Sender radio_modem{modem.system, modem.component, 0}, nobody{7, 7, 0}, robot_itself{1, 1, 0},
    pilot_itself{255, 190, 0};

static std::vector<Bytes> floods() {
    mavlink_radio_status_t full{};  // a full transmit buffer
    full.rssi = full.remrssi = 200;
    const mavlink_command_long_t other = command(MAV_CMD_NAV_TAKEOFF);
    return {unsigned_frame(full, radio_modem),
            unsigned_frame(full, nobody),
            unsigned_frame(other, nobody),
            unsigned_frame(mavlink_ping_t{}, nobody),
            unsigned_frame(other, nobody, true),
            unsigned_frame(mavlink_heartbeat_t{}, pilot_itself),
            unsigned_frame(mavlink_timesync_t{}, pilot_itself),
            unsigned_frame(mavlink_param_request_list_t{}, pilot_itself),
            unsigned_frame(mavlink_mission_count_t{}, pilot_itself),
            unsigned_frame(other, robot_itself)};
}

/// The beginning of a long frame that never ends, and frames whose signature never comes.
static std::vector<Bytes> torn_frames() {
    mavlink_file_transfer_protocol_t m{};
    std::fill(std::begin(m.payload), std::end(m.payload), std::uint8_t(1));
    Bytes bytes = unsigned_frame(m, nobody);
    bytes.resize(head_length);
    return {bytes, unsigned_frame(m, nobody, true), unsigned_frame(m, robot_itself, true),
            unsigned_frame(mavlink_radio_status_t{}, radio_modem, true)};
}

struct SafeOrder {
    mavlink_command_long_t command;
    State before, after;
};

/// Every safety order, in all forms in which a ground station sends it.
static std::vector<SafeOrder> safe_orders() {
    const auto mode = [](State state) {
        return command(MAV_CMD_DO_SET_MODE, MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, float(mode_base + int(state)));
    };
    const auto submode = [](float number) {
        mavlink_command_long_t m = command(MAV_CMD_DO_SET_MODE, MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, 4);
        m.param3 = number;
        return m;
    };
    return {{command(MAV_CMD_NAV_RETURN_TO_LAUNCH), State::gait, State::home},
            {command(MAV_CMD_NAV_LAND), State::gait, State::surface},
            {command(MAV_CMD_DO_PAUSE_CONTINUE, 0), State::gait, State::rest},
            {mode(State::rest), State::gait, State::rest},
            {mode(State::manual), State::gait, State::manual},
            {mode(State::paused), State::gait, State::rest},
            {mode(State::home), State::rest, State::home},
            {mode(State::surface), State::manual, State::surface},
            {command(MAV_CMD_DO_SET_STANDARD_MODE, MAV_STANDARD_MODE_SAFE_RECOVERY), State::manual, State::home},
            {submode(3), State::gait, State::rest},
            {submode(5), State::rest, State::home},
            {submode(6), State::home, State::surface},
            {command(MAV_CMD_COMPONENT_ARM_DISARM, 0), State::gait, State::disarmed}};
}

static constexpr Station pilot_station{255, 190};

/// The number of 30 safety orders, a second apart and each said once, that are carried out.
static int carried_out(Flooded& bench) {
    const auto orders = safe_orders();
    for (int k = 0; k < 1000; ++k) bench.endure();
    int count = 0;
    bench.board.said.clear();
    for (int k = 0; k < 30; ++k) {
        const SafeOrder& order = orders[std::size_t(k) % orders.size()];
        Vehicle& vehicle = bench.app.vehicle;
        give(vehicle, order.before == State::disarmed ? Order::disarm : Order::arm, pilot_station);
        vehicle.now.state = order.before;
        count += bench.brings(order.command, order.after);
    }
    return count;
}

/// Unsigned frames, 100 a second or as many as the line carries, keep no safety order from a signed robot at the
/// default rate, and no answer from its ground: 30 of 30.
static void test_safety_orders_in_a_flood() {
    for (const int line : {0, 6, 12})
        for (const Bytes& junk : floods()) {
            Flooded bench(junk, line);
            CHECK(carried_out(bench) == 30);
            const auto answers = said<mavlink_command_ack_t>(bench.board.said);
            CHECK(answers.size() == 30);
            for (const auto& answer : answers) CHECK(answer.result == MAV_RESULT_ACCEPTED);
            CHECK(said<mavlink_heartbeat_t>(bench.board.said).size() >= 29);
        }
}

/// A frame that the ground station signed once, said again and again, keeps no safety order either.
static void test_safety_orders_beside_a_replayed_one() {
    for (const int line : {0, 6}) {
        Flooded bench({}, line);
        bench.junk = bench.frame(command(MAV_CMD_DO_PAUSE_CONTINUE, 0));
        bench.say(command(MAV_CMD_DO_PAUSE_CONTINUE, 0));
        CHECK(carried_out(bench) == 30);
    }
}

/// With every place for answers taken, a safety order is carried out at once without an answer; another order waits.
static void test_no_room_for_an_answer() {
    for (const SafeOrder& order : safe_orders()) {
        Flooded bench({});
        Vehicle& vehicle = bench.app.vehicle;
        vehicle.now.state = order.before;
        while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
        bench.say(order.command, 1);
        CHECK(vehicle.now.state == order.after && bench.app.radio.no_room == 0);
    }
    Flooded bench({});
    for (const auto& other : {command(MAV_CMD_COMPONENT_ARM_DISARM, 1), command(MAV_CMD_MISSION_START),
                              command(MAV_CMD_DO_PAUSE_CONTINUE, 1), command(HYPERTUNA_CMD_GAIT, 2, 10)}) {
        const std::uint32_t before = bench.app.radio.no_room;
        while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
        bench.say(other, 1);
        CHECK(bench.app.radio.no_room == before + 1);
    }
    mavlink_set_mode_t mode{};
    mode.target_system = 1, mode.base_mode = MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    mode.custom_mode = std::uint32_t(mode_base + int(State::surface));
    while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
    bench.say(mode, 1);
    CHECK(snapshot(bench.vehicle()).state == State::surface);
}

/// Joystick messages have no answer and wait for no place: centered sticks stop the tail.
static void test_sticks_without_room() {
    Flooded bench({});
    give(bench.app.vehicle, Order::manual, pilot_station);
    mavlink_manual_control_t stick{};
    stick.target = 1, stick.z = 500;
    bench.say(stick, 2);
    stick.z = 750;
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency > 0);
    while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
    stick.z = 500;
    bench.say(stick, 1);
    CHECK(bench.vehicle().requested.frequency == 0);
}

/// An unfinished frame does not delay the frames behind it.
static void test_torn_frames() {
    Flooded bench({});
    for (const Bytes& torn : torn_frames())
        for (const SafeOrder& order : safe_orders()) {
            bench.app.vehicle.now.state = order.before;
            bench.hear(torn);
            bench.say(order.command, 2);
            CHECK(snapshot(bench.vehicle()).state == order.after);
            give(bench.app.vehicle, Order::arm, pilot_station);
        }
}

/// However small the robot's share of the radio is, it sends a heartbeat and answers a command each second.
static void test_least_rate() {
    Flooded bench({});
    bench.app.vehicle.model.limits.link_share = 0.05f;
    for (int k = 0; k < 1000; ++k) bench.run(1);
    bench.board.said.clear();
    const int seconds = 30;
    for (int k = 0; k < seconds; ++k) bench.say(command(MAV_CMD_NAV_LAND), 100);
    CHECK(int(said<mavlink_heartbeat_t>(bench.board.said).size()) >= seconds - 1);
    CHECK(int(said<mavlink_command_ack_t>(bench.board.said).size()) >= seconds - 1);
}

int main() {
    test_safety_orders_in_a_flood();
    test_safety_orders_beside_a_replayed_one();
    test_no_room_for_an_answer();
    test_sticks_without_room();
    test_torn_frames();
    test_least_rate();
    return failures();
}
