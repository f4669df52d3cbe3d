/// The vehicle under a mission is the pilot of the core; black box, positions, samples, late ticks.
#include "vehicle_test.hpp"

/// Under a mission the vehicle is the pilot of the core, bit for bit.
static void it_is_the_pilot_of_the_core() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    static hypertuna::PilotStep<float> core;
    core.state = v.state;
    for (int k = 0; k < 3000; ++k) {
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.fixed = k % 100 == 0;
        board.raw.fix[0] = k, board.raw.fix[1] = -k;
        tick(v, board);
        core = fly(v.model.pilot, core.state, snapshot(v).readings, v.mission);
        CHECK(std::memcmp(&core.output.pulse, &snapshot(v).output.pulse, sizeof(core.output.pulse)) == 0);
        CHECK(same_bits(core.estimate.x, snapshot(v).estimate.x) && core.mode == snapshot(v).mode);
        if (failed_checks > 0) return;
    }
    CHECK(snapshot(v).mode != Mode::idle && beats());
}

/// A ring that is full to the last word keeps its content.
static void a_full_ring() {
    static BlackBox box;
    box = {};
    while (box.in + 54 <= ring_words) {
        Record record(box, Kind::tick);
        for (int k = 0; k < 52; ++k) record.put(std::uint32_t(k));
        record.end();
    }
    Record last(box, Kind::tick);
    while (box.in < ring_words - 1) last.put(0.0f);
    last.end();
    CHECK(box.in == ring_words && box.lost == 0);
    const std::uint32_t first = box.ring[0];
    Record more(box, Kind::tick);
    more.put(1.0f), more.end();
    CHECK(box.ring[0] == first && box.in == ring_words && box.lost == 1);
}

/// The black box holds every tick in order; where the card is too slow, whole records are missing, never parts.
static void the_black_box() {
    for (int card : {1 << 16, 100}) {
        begin();
        board.card = card;
        float_on(v, board, 200);
        const auto word = [&](int at) { return word_at(board.box + 4 * at); };
        std::uint32_t expected = 0, missing = 0;
        int records = 0;
        CHECK(word(0) == (record_mark | std::uint32_t(Kind::robot) << 8 | 3) && word(1) == record_layout);
        CHECK(word(2) == robot::description.layout && word(3) == 2);
        for (int at = 5; at + 54 <= board.logged / 4; at += 54, ++records) {
            CHECK(word(at) == (record_mark | std::uint32_t(Kind::tick) << 8 | 52));
            std::uint32_t sum = 0, sums = 0;
            for (int k = 0; k < 53; ++k) sum += word(at + k), sums += sum;
            CHECK(word(at + 53) == sums);
            missing += word(at + 1) - expected, expected = word(at + 1) + 1;
        }
        CHECK((missing == 0) == (card == 1 << 16) && (v.box.lost == 0) == (missing == 0));
        CHECK(snapshot(v).faults.has(Fault::black_box) == (missing != 0));
        CHECK(records > 80);
    }
}

/// Places: one ten-millionth of a degree is 1.11 cm of latitude; the date line is no border.
static void places() {
    const Origin equator = origin_at(0, 0);
    CHECK_NEAR(local(equator, 10000000, 0).y, 110574, 2);  // WGS 84: a degree of latitude there
    CHECK_NEAR(local(equator, 0, 10000000).x, 111319, 2);
    const Origin north = origin_at(600000000, 1799999000);
    CHECK_NEAR(local(north, 600000000, -1799999000).x, 2000 * 111319e-7 * 0.5 * 1.0025, 0.02);
    CHECK_NEAR(local(north, 600010000, 1799999000).y, 111.41, 0.02);
    CHECK(is_place(-899999999, 1800000000) && !is_place(INT32_MIN, 0) && !is_place(0, INT32_MAX));
    CHECK(abs(local(north, INT32_MIN, INT32_MAX).y) > 1e6f);  // no place at all, and no overflow
}

/// The mean of a tick leaves out the extremes of three or more samples; no samples are no reading.
static void samples() {
    Samples s{};
    CHECK(mean(s) != mean(s));
    s.add(5);
    CHECK(mean(s) == 5);
    s.add(8);
    CHECK(mean(s) == 6.5f);
    s.add(60000), s.add(7);
    CHECK(mean(s) == 7.5f);  // of 5, 7, 8, 60000
}

/// A bus that hangs delays ticks: the fault is reported, and beat and clock keep their time.
static void late_ticks() {
    const auto swims = [](std::uint32_t counts, int ticks) {
        begin_armed();
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        contact(300);
        board.took = 0;
        const std::uint32_t before = v.now.tick;
        int beats = 0;
        float last = 0;
        for (int k = 0; k < ticks; ++k) {
            board.took += counts;
            contact(1);
            const float set = v.now.output.set[0];
            beats += last < 0 && 0 <= set, last = set;
        }
        CHECK(v.now.faults.has(Fault::overrun) == (counts > 1500));
        CHECK_NEAR(float(v.now.tick - before), float(counts) * float(ticks) / 1000.0f, 2);
        return beats;
    };
    const int beats = swims(1000, 2000);
    CHECK(38 <= beats && beats <= 41);                // 20 s at 2 Hz
    CHECK(std::abs(swims(1724, 1160) - beats) <= 1);  // 20 s at 58 Hz
    // A second is lost when the clock jumped by a second: at most five steps are made up for.
    begin_armed();
    contact(10);
    const std::uint32_t before = v.now.tick;
    board.took += 100'000;
    contact(1);
    CHECK(v.now.tick == before + 5);
    contact(1);
    CHECK(v.now.tick == before + 6);
}

/// An erasure, while disarmed, delays the next tick and is no fault; what is late besides is one. The clock keeps its
/// time.
static void erasures_are_not_late() {
    const auto stores = [](std::uint32_t erasing, std::uint32_t besides) {
        begin(), float_on(v, board, 100);
        board.took = v.started, board.erasing = erasing;
        const std::uint32_t before = v.now.tick;
        CHECK(set_parameter(v, ground, index_of("learning"), 0.5f) == Refusal::none);
        bool late = false;
        for (int k = 0; k < 100; ++k) {
            board.took += k == 1 ? besides : 1000;
            float_on(v, board, 1), late = late || v.now.faults.has(Fault::overrun);
        }
        CHECK(board.flash.erasures == 1 && settled(v.store));
        CHECK_NEAR(float(v.now.tick - before), 100 + std::min(float(erasing) / 1000, 4.0f), 2);
        return late;
    };
    for (std::uint32_t erasing : {4'500u, 40'000u}) CHECK(!stores(erasing, 1000) && stores(erasing, 2000));
}

int main() {
    late_ticks();
    erasures_are_not_late();
    it_is_the_pilot_of_the_core();
    a_full_ring();
    the_black_box();
    places();
    samples();
    CHECK(allocations == 0);
    return failures();
}
