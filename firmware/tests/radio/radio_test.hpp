/// A robot on the bench and a ground station that writes frames, for the tests of the radio.
#pragma once

#include <string_view>

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
    /// Send something, and let the robot answer.
    template <class Message>
    void say(const Message& m, int ticks = 40) {
        hear(frame(m));
        run(ticks);
    }
    const Vehicle& vehicle() const { return app.vehicle; }
};

/// Every frame of a kind that the robot has sent, decoded as a client would.
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

/// The last frame of a kind; zeros if there is none.
template <class Message>
Message last_said(const Bench& bench) {
    const auto all = said<Message>(bench.board.said);
    CHECK(!all.empty());
    return all.empty() ? Message{} : all.back();
}

inline mavlink_command_long_t command(int what, float first = 0, float second = 0) {
    mavlink_command_long_t m{};
    m.command = std::uint16_t(what), m.param1 = first, m.param2 = second, m.target_system = 1;
    return m;
}

inline Refusal last_answer(const Bench& bench) {
    return Refusal(last_said<mavlink_command_ack_t>(bench).result_param2);
}

/// The number of times that a text was sent.
inline int texts_sent(const Bench& bench, std::string_view text) {
    int count = 0;
    for (const auto& m : said<mavlink_statustext_t>(bench.board.said))
        count += std::string_view(m.text, strnlen(m.text, sizeof m.text)) == text;
    return count;
}
inline int texts_sent(const Bench& bench, Refusal refusal) { return texts_sent(bench, sentence(refusal)); }

/// Answer the robot's requests for items as a ground station does.
inline std::uint8_t upload(Bench& bench, std::vector<mavlink_mission_item_int_t> items, std::size_t from = 0,
                           std::uint8_t type = MAV_MISSION_TYPE_MISSION) {
    mavlink_mission_count_t count{};
    count.count = std::uint16_t(items.size()), count.target_system = 1, count.mission_type = type;
    bench.board.said.clear();
    bench.say(count);
    for (std::size_t k = from; k < items.size(); ++k) {
        items[k].seq = std::uint16_t(k), items[k].target_system = 1, items[k].mission_type = type;
        bench.say(items[k]);
    }
    bench.run(40);  // a text may be sent before the answer
    const auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    return acks.empty() ? 255 : acks.back().type;
}

/// Ask for a list as a ground station does.
inline std::vector<mavlink_mission_item_int_t> download(Bench& bench, std::uint8_t type = MAV_MISSION_TYPE_MISSION) {
    mavlink_mission_request_list_t list{};
    list.target_system = 1, list.mission_type = type;
    bench.board.said.clear();
    bench.say(list);
    const auto counts = said<mavlink_mission_count_t>(bench.board.said);
    CHECK(counts.size() == 1 && counts[0].mission_type == type);
    mavlink_mission_request_int_t request{};
    request.target_system = 1, request.mission_type = type;
    for (int k = 0; !counts.empty() && k < counts[0].count; ++k) request.seq = std::uint16_t(k), bench.say(request);
    return said<mavlink_mission_item_int_t>(bench.board.said);
}

/// Whether two items are the same, NaN included.
inline bool same(const mavlink_mission_item_int_t& a, const mavlink_mission_item_int_t& b) {
    const auto equal = [](float x, float y) { return x == y || (!is_finite(x) && !is_finite(y)); };
    return a.command == b.command && a.frame == b.frame && a.x == b.x && a.y == b.y && equal(a.z, b.z) &&
           equal(a.param1, b.param1) && equal(a.param2, b.param2) && equal(a.param3, b.param3) &&
           equal(a.param4, b.param4);
}

inline mavlink_mission_item_int_t item(int what, float north, float east, float z, float first = 0, float second = 0) {
    mavlink_mission_item_int_t m{};
    m.command = std::uint16_t(what), m.frame = MAV_FRAME_LOCAL_NED, m.z = z, m.param1 = first, m.param2 = second;
    m.x = std::int32_t(north * 1e4f), m.y = std::int32_t(east * 1e4f);
    return m;
}

inline std::vector<mavlink_mission_item_int_t> box() {
    std::vector<mavlink_mission_item_int_t> items = {item(HYPERTUNA_CMD_BOUNDS, 3e-4f, 0.025f, 0.4f, 4, 0.2f),
                                                     item(HYPERTUNA_CMD_DECLINATION, 0, 0, 0, -9),
                                                     item(MAV_CMD_DO_SET_HOME, 1, 2, 0)};
    for (int k = 0; k < 4; ++k)
        items.push_back(item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, k < 2 ? -50.0f : 50.0f,
                             k % 3 == 0 ? -50.0f : 50.0f, 0, 4));
    items.push_back(item(MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, 0, 0.35f));
    for (int k = 0; k < 3; ++k)
        items.push_back(item(MAV_CMD_NAV_WAYPOINT, 10.0f * float(k), 20, 1.5f, 30.0f * float(k), 2));
    return items;
}
