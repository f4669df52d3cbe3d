/// Fuzzing of the radio: any bytes, in any portions, to a robot that is armed, with and without signing; and without
/// libFuzzer, sessions of a hostile station: fuzz_radio SECONDS SEED.
///
/// The first byte chooses; then portions: a length, and as many bytes for one tick. With the right checksum put into
/// every second portion that looks like a frame, the handlers behind the parser are reached, too. What must hold after
/// every tick is checked, beside what the sanitizers see.
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "hostile.hpp"

static constexpr Station ground{255, 190};

static void must(bool holds) {
    if (!holds) std::abort();
}

static void check(const App& app) {
    const Snapshot& now = snapshot(app.vehicle);
    const Outbox& out = app.radio.out;
    must(0 <= out.fill && out.fill <= outbox_size && 0 <= out.answers && out.answers <= max_answers);
    must(out.allowance <= float(max_frame) + out.rate && -float(max_frame + packet_cost) <= out.allowance);
    must(-float(max_frame + packet_cost) <= app.radio.telemetry.allowance);
    must(is_finite(now.command.frequency) && 0 <= now.command.frequency && now.command.frequency <= 8);
    const Mission<float>& m = mission(app.vehicle);
    must(0 <= m.waypoints && m.waypoints <= max_waypoints && 0 <= m.corners && m.corners <= max_corners);
    const MissionForm& form = app.vehicle.plan.form;
    must(is_valid(form, m.waypoints, m.corners) && (m.waypoints == 0) != app.vehicle.has_mission);
    for (int k = 0; k < m.waypoints; ++k) must(is_finite(m.waypoint[k].x) && 0 < m.waypoint[k].speed);
    const auto home = home_of(app.vehicle);
    const PlanNumbers &kept = app.vehicle.numbers, right = numbers_of(app.vehicle.plan);
    must(is_finite(home.x + home.y) && kept.mission == right.mission && kept.fence == right.fence);
    for (int k = 0; k < parameter_count(app.vehicle); ++k) {
        const ParameterInfo& info = parameter(app.vehicle, k);
        must(info.low <= value(app.vehicle, k) && value(app.vehicle, k) <= info.high);
    }
}

#ifdef HYPERTUNA_LIBFUZZER

/// Give a portion mark, flags and checksum, so that it is a frame of the kind that its id picks.
static int make_frame(std::uint8_t* bytes, int count) {
    if (count < head_length + 1 + crc_length) return count;
    const MessageKind& kind = accepted.kind[bytes[7] % (sizeof accepted.kind / sizeof accepted.kind[0])];
    const int room = count - head_length - crc_length, payload = room < kind.max_length ? room : kind.max_length;
    bytes[0] = frame_mark, bytes[1] = std::uint8_t(payload), bytes[2] = 0;
    for (int k = 0; k < 3; ++k) bytes[7 + k] = std::uint8_t(kind.id >> 8 * k);
    const std::uint16_t crc = frame_crc(bytes, head_length + payload, kind.crc_extra);
    bytes[head_length + payload] = std::uint8_t(crc), bytes[head_length + payload + 1] = std::uint8_t(crc >> 8);
    return head_length + payload + crc_length;
}

static App app;
static BenchBoard board;
static App fresh_app;
static BenchBoard fresh_board;

/// A robot that has found its attitude, and is armed.
static bool prepare() {
    boot(fresh_app, robot::description, fresh_board);
    for (int k = 0; k < 60; ++k) tick(fresh_app, fresh_board);
    must(give(fresh_app.vehicle, Order::arm, ground) == Refusal::none);
    fresh_board.said.clear();
    return true;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const bool ready = prepare();
    if (!ready || size < 2) return 0;
    app = fresh_app, board = fresh_board;
    const std::uint8_t choice = data[0];
    if (choice & 1) give(app.vehicle, Order::disarm, ground);
    if ((choice & 2) && size > key_length) {
        std::memcpy(app.vehicle.secret.key, data, key_size);
        app.vehicle.secret.present = 1, app.vehicle.model.limits.sign = 1.0f;
    }
    std::size_t at = 1;
    for (int portion = 0; at < size && portion < 64; ++portion) {
        const std::size_t portion_size = 1 + std::size_t(data[at++] % 96);
        const std::size_t count = portion_size < size - at ? portion_size : size - at;
        std::uint8_t bytes[96];
        std::memcpy(bytes, data + at, count);
        at += count;
        const int length = portion % 2 == 0 || (choice & 4) ? make_frame(bytes, int(count)) : int(count);
        board.heard.assign(bytes, bytes + length);
        tick(app, board);
        check(app);
        board.said.clear();
    }
    return 0;
}
#else

/// A session: services, orders and missions of a hostile station, with a right, a wrong or no signature; frames are
/// repeated, torn or damaged, and come in any portions.
static void session(Chance& chance, long& frames) {
    Bench bench;
    if (chance.below(2)) give(bench.app.vehicle, Order::arm, ground);
    Bytes before;
    for (int step = 0; step < 200; ++step) {
        const std::size_t kind = chance.below(16);
        if (kind == 0) send_mission(bench, chance);
        if (kind == 1) bench.hear(before);
        if (kind == 2) begin_signing(bench.key, bench.vehicle().secret.key, bench.app.radio.signing.stamp);
        if (kind == 3) bench.key.stamp = chance.below(2) ? bench.app.radio.signing.stamp : chance.bits() >> 16;
        if (kind == 4) bench.key.on = !bench.key.on;
        if (kind == 5) bench.ground = {std::uint8_t(chance.bits()), std::uint8_t(chance.bits()), 0};
        if (kind == 6) bench.ground = {255, 190, std::uint8_t(chance.bits())};
        if (kind == 7) bench.board.depth = float(chance.below(60)) - 10.0f, bench.board.leak = chance.below(2);
        for (std::size_t k = kind > 7 ? chance.below(5) : 0; k > 0; --k)
            send_hostile(Dialect{}, bench, chance, chance.below(64));
        Bytes& heard = bench.board.heard;
        if (!heard.empty() && chance.below(8) == 0) heard[chance.below(heard.size())] ^= std::uint8_t(chance.bits());
        if (!heard.empty() && chance.below(16) == 0) heard.resize(chance.below(heard.size()));
        if (!heard.empty()) before = heard;
        for (std::size_t k = chance.below(chance.below(20) ? 3 : 60);; --k) {
            bench.run(1);
            check(bench.app);
            if (k == 0) break;
        }
        bench.board.said.clear();
        if (bench.app.radio.restart_at != 0) break;
    }
    frames += bench.app.radio.parser.frames;
}

int main(int count, char** words) {
    const double seconds = count > 1 ? std::atof(words[1]) : 1;
    Chance chance{std::mt19937_64(count > 2 ? std::strtoull(words[2], nullptr, 10) : 1)};
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    long sessions = 0, frames = 0;
    for (; std::chrono::steady_clock::now() < end; ++sessions) session(chance, frames);
    std::printf("%ld sessions, %ld valid frames\n", sessions, frames);
    return failures();
}
#endif
