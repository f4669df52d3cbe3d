/// The radio: frames found in any stream of bytes, orders followed or refused with a reason, missions that are whole or
/// not at all, signatures, and a radio that is never asked for more than it carries.
#include "../../../core/tests/check.hpp"
#include "app/radio/dispatch.hpp"
#include "bench_board.hpp"

using namespace hypertuna;
using namespace hypertuna::firmware;

using Bytes = std::vector<std::uint8_t>;

/// A robot on the bench, and a ground station that writes frames.
struct Bench {
    App app{};
    BenchBoard board{};
    Sender ground{255, 190, 0};
    Signing key{};

    Bench() {
        boot(app, robot::description, board);
        run(60);
    }
    template <class Message>
    Bytes frame(const Message& m) {
        Bytes bytes(max_frame);
        int length =
            write_frame(bytes.data(), kind_of<Message>, reinterpret_cast<const std::uint8_t*>(&m), ground, key.on);
        if (key.on) length = sign(key, bytes.data(), length);
        bytes.resize(std::size_t(length));
        return bytes;
    }
    void hear(const Bytes& bytes) { board.heard.insert(board.heard.end(), bytes.begin(), bytes.end()); }
    void run(int ticks) {
        for (int k = 0; k < ticks; ++k) tick(app, board);
    }
    /// Say something, and let the robot answer.
    template <class Message>
    void say(const Message& m, int ticks = 40) {
        hear(frame(m));
        run(ticks);
    }
    const Vehicle& vehicle() const { return app.vehicle; }
};

/// Every frame that the robot has sent of a kind. Its frames are read as a client's would be.
template <class Message>
std::vector<Message> said(const Bytes& bytes) {
    std::vector<Message> found;
    for (std::size_t at = 0; at + head_length < bytes.size();) {
        const std::size_t length = bytes[at + 1];
        CHECK(bytes[at] == frame_mark);
        if (id_of(&bytes[at]) == kind_of<Message>.id) {
            Message m{};
            std::memcpy(static_cast<void*>(&m), &bytes[at + head_length], length);
            found.push_back(m);
        }
        at += head_length + length + crc_length + (bytes[at + 2] ? signature_length : 0);
    }
    return found;
}

static mavlink_command_long_t command(int what, float first = 0, float second = 0) {
    mavlink_command_long_t m{};
    m.command = std::uint16_t(what), m.param1 = first, m.param2 = second, m.target_system = 1;
    return m;
}

static Refusal last_answer(Bench& bench) {
    const auto acks = said<mavlink_command_ack_t>(bench.board.said);
    CHECK(!acks.empty());
    return acks.empty() ? Refusal::count : Refusal(acks.back().result_param2);
}

/// How often a reason was told.
static int told(const Bench& bench, Refusal refusal) {
    int count = 0;
    for (const auto& m : said<mavlink_statustext_t>(bench.board.said))
        count += std::strncmp(m.text, sentence(refusal), sizeof m.text) == 0;
    return count;
}

/// Check value of CRC-16/MCRF4XX (reveng.sourceforge.io/crc-catalogue), and of SHA-256 (FIPS 180-4, "abc").
static void test_checksums() {
    std::uint16_t crc = 0xFFFF;
    for (char c : {'1', '2', '3', '4', '5', '6', '7', '8', '9'}) crc = crc_step(crc, std::uint8_t(c));
    CHECK(crc == 0x6F91);
    Sha256 hash;
    add(hash, reinterpret_cast<const std::uint8_t*>("abc"), 3);
    std::uint8_t digest[32];
    finish(hash, digest, 32);
    CHECK(digest[0] == 0xba && digest[1] == 0x78 && digest[2] == 0x16 && digest[3] == 0xbf && digest[31] == 0xad);
}

/// A good frame is found behind any bytes whatever, and inside of a bad frame's.
static void test_parser_finds_what_is_good() {
    Bench bench;
    const Bytes good = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        Bytes stream(random_bits(seed, 0, 0) % 400);
        for (std::size_t k = 0; k < stream.size(); ++k) stream[k] = std::uint8_t(random_bits(seed, 1, k));
        if (seed % 2) stream.insert(stream.end(), good.begin(), good.begin() + long(seed / 2 % (good.size() - 1)));
        stream.insert(stream.end(), good.begin(), good.end());
        Parser parser{};
        Frame frame{};
        int found = 0;
        for (std::size_t at = 0; at < stream.size();) {
            at += std::size_t(feed(parser, &stream[at], int(stream.size() - at)));
            while (next(parser, frame)) ++found;
        }
        // What waits for more bytes than came is told apart by the next good frame at the latest.
        for (std::uint8_t byte : good) feed(parser, &byte, 1);
        while (next(parser, frame)) ++found;
        CHECK(found == 2);
    }
}

/// Any single bit that flips is seen; two thirds of the frame's bytes may be anything.
static void test_no_flipped_bit_passes() {
    Bench bench;
    const Bytes good = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bad = good;
        bad[bit / 8] = std::uint8_t(bad[bit / 8] ^ 1 << bit % 8);
        Parser parser{};
        Frame frame{};
        feed(parser, bad.data(), int(bad.size()));
        CHECK(!next(parser, frame));
    }
}

static void test_arm_gait_disarm() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(last_answer(bench) == Refusal::none);
    CHECK(snapshot(bench.vehicle()).armed);
    mavlink_command_long_t gait = command(HYPERTUNA_CMD_GAIT, 2, 10);
    gait.param3 = 15, gait.param4 = 40;
    bench.say(gait);
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(snapshot(bench.vehicle()).command.frequency, 2, 1e-6);
    CHECK_NEAR(snapshot(bench.vehicle()).command.amplitude[1], 15 * pi / 180, 1e-6);
    gait.param1 = 1000;
    bench.say(gait);
    CHECK(last_answer(bench) == Refusal::out_of_range);
    CHECK(told(bench, Refusal::out_of_range) == 1);
    CHECK_NEAR(snapshot(bench.vehicle()).command.frequency, 2, 1e-6);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    CHECK(!snapshot(bench.vehicle()).armed);
    for (float value : {0.5f, 2.0f, -1.0f, std::bit_cast<float>(0x7fc00000u)}) {
        bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, value));
        CHECK(last_answer(bench) == Refusal::out_of_range);
    }
    bench.say(command(MAV_CMD_NAV_LAND));
    CHECK(last_answer(bench) == Refusal::unknown);
}

/// The same frame again, and one that was overtaken, are old; so is all of a window. After silence a sender counts
/// anew.
static void test_replay_is_refused() {
    Bench bench;
    const Bytes arm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    const Bytes disarm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    bench.hear(disarm), bench.run(40);
    bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed);
    bench.hear(disarm), bench.run(40);
    CHECK(bench.app.radio.replayed == 2);
    CHECK(told(bench, Refusal::replayed) == 1);
    bench.run(int(silence) + 1);
    bench.hear(arm), bench.run(40);
    CHECK(snapshot(bench.vehicle()).armed);
}

static void test_parameters() {
    Bench bench;
    mavlink_param_set_t set{};
    set.target_system = 1, set.param_type = MAV_PARAM_TYPE_REAL32, set.param_value = 0.25f;
    put_text(set.param_id, "proportional");
    bench.say(set);
    const int k = parameter_named(bench.vehicle(), "proportional");
    CHECK(value(bench.vehicle(), k) == 0.25f);
    for (float wrong : {7.0f, std::bit_cast<float>(0x7fc00000u)}) {
        set.param_value = wrong;
        bench.board.said.clear();
        bench.say(set, 200);
        CHECK(value(bench.vehicle(), k) == 0.25f);
        const auto values = said<mavlink_param_value_t>(bench.board.said);
        CHECK(values.size() == 1 && values[0].param_value == 0.25f);
        CHECK(said<mavlink_param_error_t>(bench.board.said).size() == 1);
        CHECK(told(bench, Refusal::out_of_range) == 1);
    }
    bench.board.said.clear();
    mavlink_param_request_list_t list{};
    list.target_system = 1;
    bench.say(list, 2000);
    const auto values = said<mavlink_param_value_t>(bench.board.said);
    CHECK(int(values.size()) == parameter_count(bench.vehicle()));
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(values[i].param_index == i);
}

/// Answer the robot's requests for items as a ground station does.
static std::uint8_t upload(Bench& bench, std::vector<mavlink_mission_item_int_t> items, std::size_t from = 0) {
    mavlink_mission_count_t count{};
    count.count = std::uint16_t(items.size()), count.target_system = 1;
    bench.board.said.clear();
    bench.say(count);
    for (std::size_t k = from; k < items.size(); ++k) {
        items[k].seq = std::uint16_t(k), items[k].target_system = 1;
        bench.say(items[k]);
    }
    const auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    return acks.empty() ? 255 : acks.back().type;
}

static mavlink_mission_item_int_t item(int what, float north, float east, float z, float first = 0, float second = 0) {
    mavlink_mission_item_int_t m{};
    m.command = std::uint16_t(what), m.frame = MAV_FRAME_LOCAL_NED, m.z = z, m.param1 = first, m.param2 = second;
    m.x = std::int32_t(north * 1e4f), m.y = std::int32_t(east * 1e4f);
    return m;
}

static std::vector<mavlink_mission_item_int_t> box() {
    std::vector<mavlink_mission_item_int_t> items = {item(HYPERTUNA_CMD_BOUNDS, 1e-4f, 0.025f, 0.4f, 4, 0.2f),
                                                     item(MAV_CMD_DO_SET_HOME, 1, 2, 0)};
    for (int k = 0; k < 4; ++k)
        items.push_back(item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, k < 2 ? -50.0f : 50.0f,
                             k % 3 == 0 ? -50.0f : 50.0f, 0, 4));
    items.push_back(item(MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, 0, 0.35f));
    for (int k = 0; k < 3; ++k) items.push_back(item(MAV_CMD_NAV_WAYPOINT, 10.0f * float(k), 20, 1.5f, 0, 2));
    return items;
}

/// Up, and down again: the same items. One that is broken off, or has a bad item, leaves what was on board.
static void test_missions() {
    Bench bench;
    const auto items = box();
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    const Mission<float>& m = mission(bench.vehicle());
    CHECK(m.waypoints == 3 && m.corners == 4 && m.depth_most == 4.0f && m.reserve == 0.2f);
    CHECK(m.stay && m.home_radius == 2.5f && m.home_speed == 0.4f);
    CHECK(m.waypoint[2].x == 20.0f && m.waypoint[2].y == 20.0f && m.waypoint[2].depth == 1.5f);
    CHECK(m.waypoint[1].speed == 0.35f && m.home.x == 2.0f && m.home.y == 1.0f);

    std::size_t same = 0;
    CHECK(visit_items(m, [&](const mavlink_mission_item_int_t& got) {
              const auto& sent = items[same++];
              CHECK(got.command == sent.command && got.x == sent.x && got.y == sent.y && got.z == sent.z);
              CHECK(got.param1 == sent.param1 && got.param2 == sent.param2);
          }) == int(items.size()));

    auto bad = items;
    bad[8].z = std::bit_cast<float>(0x7fc00000u);
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bad = items, bad[8].frame = MAV_FRAME_BODY_FRD;
    CHECK(upload(bench, bad) == MAV_MISSION_UNSUPPORTED_FRAME);
    bad = {items[0], items[1]};
    CHECK(upload(bench, bad) == MAV_MISSION_ERROR);
    bad = items, bad[0].param1 = 1e6f;  // the vehicle's own check, of the whole
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    CHECK(mission(bench.vehicle()).waypoints == 3 && mission(bench.vehicle()).depth_most == 4.0f);

    CHECK(upload(bench, {items.begin(), items.end()}, items.size()) == 255);  // no item comes at all
    bench.run(int(request_timeout) * (max_tries + 1));
    const auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(!acks.empty() && acks.back().type == MAV_MISSION_OPERATION_CANCELLED);
    CHECK(said<mavlink_mission_request_int_t>(bench.board.said).size() == max_tries);
    CHECK(mission(bench.vehicle()).waypoints == 3);
}

/// The last item once more, because its answer was lost: the same answer once more.
static void test_lost_acknowledgement_of_a_mission() {
    Bench bench;
    auto items = box();
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    bench.board.said.clear();
    items.back().seq = std::uint16_t(items.size() - 1), items.back().target_system = 1;
    bench.say(items.back());
    auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(acks.size() == 1 && acks[0].type == MAV_MISSION_ACCEPTED);
    auto bad = box();
    bad[9].z = -1;  // the whole is refused at its last item
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.say(items.back());
    acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(acks.size() == 1 && acks[0].type == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.ground.system = 254;  // not somebody else's
    bench.say(items.back());
    CHECK(said<mavlink_mission_ack_t>(bench.board.said).empty());
}

/// COMMAND_INT is COMMAND_LONG; a bias that it has no place for is refused, not left out.
static void test_command_int() {
    Bench bench;
    mavlink_command_int_t m{};
    m.target_system = 1, m.command = MAV_CMD_COMPONENT_ARM_DISARM, m.param1 = 1, m.x = 500000000;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::none && snapshot(bench.vehicle()).armed);
    m.command = HYPERTUNA_CMD_GAIT, m.param1 = 2, m.param2 = 10, m.param3 = 15, m.param4 = 40;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::out_of_range);
    m.x = 0;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(snapshot(bench.vehicle()).command.amplitude[1], 15 * pi / 180, 1e-6);
    m.command = MAV_CMD_COMPONENT_ARM_DISARM, m.param1 = 0;
    while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
    bench.say(m, 1);  // disarming waits for no place
    CHECK(!snapshot(bench.vehicle()).armed);
    m.target_system = 2, m.param1 = 1;
    bench.say(m);
    CHECK(!snapshot(bench.vehicle()).armed);
}

/// An axis of INT16_MAX is one that the joystick does not have.
static void test_unused_axes() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    mavlink_manual_control_t stick{};
    stick.target = 1, stick.z = 500;
    stick.x = stick.y = stick.r = INT16_MAX;
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency > 0.5f && snapshot(bench.vehicle()).command.fin[0] == 0);
    stick.r = INT16_MIN;
    const std::uint32_t before = bench.app.radio.refused;
    bench.say(stick, 2);
    CHECK(bench.app.radio.refused == before + 1);
}

/// What is said to another robot is no sign of life of this one's ground; what is said to all is.
static void test_who_is_heard() {
    Bench bench;
    for (int target : {2, 0}) {
        auto order = command(MAV_CMD_NAV_LAND);
        mavlink_manual_control_t stick{};
        mavlink_set_gps_global_origin_t place{};
        order.target_system = stick.target = place.target_system = std::uint8_t(target);
        const std::uint32_t before = bench.vehicle().ground_contact;
        bench.say(order, 1), bench.say(stick, 1), bench.say(place, 1);
        CHECK((bench.vehicle().ground_contact == before) == (target == 2));
    }
}

/// A place in degrees counts from the first fix: a thousandth of a degree of latitude is 111.2 m.
static void test_mission_in_degrees() {
    Bench bench;
    bench.run(200);
    CHECK(origin(bench.vehicle()).known);
    auto point = item(MAV_CMD_NAV_WAYPOINT, 0, 0, -1, 0, 2);
    point.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
    point.x = origin(bench.vehicle()).latitude + 10000, point.y = origin(bench.vehicle()).longitude;
    CHECK(upload(bench, {point}) == MAV_MISSION_ACCEPTED);
    CHECK_NEAR(mission(bench.vehicle()).waypoint[0].y, 111.2, 0.1);
    CHECK_NEAR(mission(bench.vehicle()).waypoint[0].x, 0, 1e-3);
    CHECK(mission(bench.vehicle()).waypoint[0].depth == 1.0f);
    point.x = INT32_MIN;
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID_PARAM5_X);
    point.x = 0, point.y = INT32_MAX;
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID_PARAM5_X);
}

static void test_signing() {
    Bench bench;
    std::uint8_t key[key_length];
    for (int k = 0; k < key_length; ++k) key[k] = std::uint8_t(k + 1);
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.initial_timestamp = 1'000'000'000;
    std::memcpy(setup.secret_key, key, key_length);
    bench.say(setup);
    CHECK(bench.app.radio.signing.on);

    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));  // without a signature
    CHECK(!snapshot(bench.vehicle()).armed && bench.app.radio.not_signed == 1);
    begin_signing(bench.key, key, 2'000'000'000);
    bench.key.key[5] ^= 1;  // a key that is not the robot's
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(!snapshot(bench.vehicle()).armed);
    bench.key.key[5] ^= 1;

    const Bytes arm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.hear(arm), bench.run(40);
    CHECK(snapshot(bench.vehicle()).armed);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    bench.run(2000);  // however long after: a recording is not believed
    bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed);

    // It lasts over a boot, and what the robot says is signed, too.
    boot(bench.app, robot::description, bench.board);
    bench.board.said.clear();
    bench.run(200);
    CHECK(bench.app.radio.signing.on && bench.board.said[2] == signed_flag);
    bench.key.on = false;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(!snapshot(bench.vehicle()).armed);
}

/// After a restart no recording is believed, not even the last one; the owner is, who hears the robot's stamps.
static void test_a_recording_after_a_restart() {
    Bench bench;
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = 1'000'000'000;
    bench.say(setup);
    begin_signing(bench.key, setup.secret_key, setup.initial_timestamp);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(snapshot(bench.vehicle()).armed);
    bench.key.stamp += 100 * stamp_minute;  // a clock that is far ahead
    const Bytes recorded = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.hear(recorded), bench.run(40);
    const std::uint64_t kept = bench.vehicle().stamp;
    CHECK(kept > bench.key.stamp && kept <= bench.key.stamp + stamp_minute + 100'000);
    int writes = 0;
    for (int k = 0; k < 6500; ++k) {
        const std::uint32_t turn = bench.vehicle().stamps.turn;
        bench.run(1);
        writes += bench.vehicle().stamps.turn != turn;
    }
    CHECK(writes == 1);  // in 65 s

    for (int restart = 0; restart < 2; ++restart) {
        boot(bench.app, robot::description, bench.board);
        bench.run(60);
        bench.hear(recorded), bench.run(40);
        CHECK(!snapshot(bench.vehicle()).armed && bench.app.radio.not_signed == 1);
        bench.key.stamp = bench.app.radio.signing.stamp;  // as the robot's own frames say
        bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
        CHECK(snapshot(bench.vehicle()).armed);
    }
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    setup.secret_key[3] = 6, setup.initial_timestamp = 1000;  // with another key another time may begin
    bench.say(setup);
    CHECK(bench.vehicle().stamp < 2 * stamp_minute);
}

/// The parameter that asks for signatures needs a key, and counts at once.
static void test_signing_by_parameter() {
    Bench bench;
    mavlink_param_set_t sign{};
    sign.target_system = 1, sign.param_type = MAV_PARAM_TYPE_REAL32, sign.param_value = 1;
    put_text(sign.param_id, "SIGN");
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on && told(bench, Refusal::inconsistent) == 1);
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = std::uint64_t(1) << 48;
    bench.say(setup);
    CHECK(!bench.app.radio.signing.on && told(bench, Refusal::out_of_range) == 1);  // a stamp has 48 bits
    setup.initial_timestamp = 1000;
    bench.say(setup);
    CHECK(bench.app.radio.signing.on);
    begin_signing(bench.key, setup.secret_key, 2000);
    sign.param_value = 0;
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on);
    bench.key.on = false, sign.param_value = 1;
    bench.run(100), bench.say(sign);
    CHECK(bench.app.radio.signing.on);
    bench.key.on = true;
    setup.secret_key[3] = 0;  // a key of zeros ends it, and is none
    bench.say(setup), bench.run(100);
    CHECK(!bench.app.radio.signing.on && key(bench.vehicle()) == nullptr);
    bench.key.on = false;
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on);
}

/// At 4.8 kbit/s: no more than its share, whatever is asked for, no answer waits behind telemetry, and no queue grows.
static void test_radio_budget() {
    Bench bench;
    bench.board.said.clear();
    for (const TelemetryMessage& message : telemetry_messages)
        if (message.id != MAVLINK_MSG_ID_HEARTBEAT)
            bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, float(message.id), 1e4f));  // 100 Hz each
    mavlink_param_request_list_t list{};
    list.target_system = 1;
    const Outbox& out = bench.app.radio.out;
    const auto cost = [&] { return double(out.sent) + packet_cost * double(out.frames); };
    const double before = cost();
    const int seconds = 60;
    for (int s = 0; s < seconds; ++s) {
        if (s % 10 == 0) bench.say(list, 1);
        for (int k = 0; k < 5; ++k) bench.say(command(MAV_CMD_NAV_LAND), 1);
        bench.run(100 - 5 - (s % 10 == 0));
    }
    const double rate = 8.0 * (cost() - before) / seconds;
    CHECK(rate <= 4800 * 0.75 * 1.01);
    CHECK(rate >= 4800 * 0.75 * 0.95);
    CHECK(bench.app.radio.out.max_waiting <= max_answers);
    CHECK(bench.app.radio.out.fill == 0);
    const auto hearts = said<mavlink_heartbeat_t>(bench.board.said);
    CHECK(int(hearts.size()) >= seconds - 2);
    for (int k = 1; k < streams; ++k) CHECK(bench.app.radio.telemetry.stream[k].sent > 0);
}

/// A radio whose buffer fills up gets less, and more again when it is empty.
static void test_radio_status() {
    Bench bench;
    mavlink_radio_status_t status{};
    status.txbuf = 10;
    for (int k = 0; k < 10; ++k) bench.say(status, 100);
    const std::uint32_t before = bench.app.radio.out.sent;
    bench.run(1000);
    CHECK(bench.app.radio.out.sent - before < 600);
    CHECK(bench.app.radio.out.sent - before > 200);
    status.txbuf = 100;
    for (int k = 0; k < 20; ++k) bench.say(status, 10);
    CHECK(bench.app.radio.telemetry.throttle == 100);
    // A radio that does not report any more may be another one.
    status.txbuf = 0;
    for (int k = 0; k < 10; ++k) bench.say(status, 10);
    CHECK(bench.app.radio.telemetry.throttle == 10);
    bench.run(1100);
    CHECK(bench.app.radio.telemetry.throttle == 100);
}

/// Angles for the compass rose, against the C library.
static void test_angles() {
    double worst = 0;
    for (int k = 0; k < 100000; ++k) {
        const double a = 2 * pi * k / 100000 - pi;
        const float y = float(std::sin(a)), x = float(std::cos(a));
        worst = std::max(worst, std::fabs(double(angle_of(y, x)) - std::atan2(double(y), double(x))));
    }
    CHECK(worst < 2e-5);
    CHECK(whole<std::int16_t>(1e9f, 1.0f) == 32767 && whole<std::int16_t>(-1e9f, 1.0f) == -32768);
    CHECK(whole<std::uint16_t>(-3.0f, 1.0f) == 0 && whole<std::int16_t>(-2.5f, 1.0f) == -3);
    CHECK(whole<std::int32_t>(4e9f, 1.0f) == INT32_MAX);
}

int main() {
    test_checksums();
    test_parser_finds_what_is_good();
    test_no_flipped_bit_passes();
    test_arm_gait_disarm();
    test_replay_is_refused();
    test_parameters();
    test_missions();
    test_mission_in_degrees();
    test_lost_acknowledgement_of_a_mission();
    test_command_int();
    test_unused_axes();
    test_who_is_heard();
    test_signing();
    test_a_recording_after_a_restart();
    test_signing_by_parameter();
    test_radio_budget();
    test_radio_status();
    test_angles();
    return failures();
}
