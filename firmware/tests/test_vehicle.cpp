/// The vehicle: who may ask for what, what each failure leads to, and that it adds nothing to the pilot of the core.
#include "../../core/tests/allocations.hpp"
#include "../../core/tests/check.hpp"
#include "memory_board.hpp"

using namespace hypertuna::firmware;
using hypertuna::Command;
using hypertuna::Mission;
using hypertuna::Mode;
using hypertuna::Reason;
using hypertuna::Waypoint;

static Vehicle v;
static MemoryBoard board;

static void begin() {
    board = {}, board.power = -1, board.card = 1 << 16;
    boot(v, robot::description, board);
}

/// Afloat, and armed.
static void begin_armed() {
    begin();
    float_on(v, board, 100);
    CHECK(arm(v, true) == Refusal::none);
}

static int index_of(const char* name) {
    for (int k = 0; k < parameter_count(v); ++k)
        if (std::strcmp(parameter(v, k).name, name) == 0) return k;
    return -1;
}

static Command<float> beat(float frequency = 2) {
    Command<float> c = rest();
    c.frequency = frequency, c.amplitude[0] = 0.2f, c.amplitude[1] = 0.3f;
    return c;
}

/// Largest amplitude that the controller is on its way to.
static bool beats() { return 0.1f < v.state.controller.wish.amplitude[0]; }

static Waypoint<float> way[2] = {{0, -40, 0, 0.3f, 2}, {0, -80, 0, 0.3f, 2}};
static Mission<float> plan() {
    Mission<float> m{};
    m.waypoint = way, m.waypoints = 2;
    m.home_radius = 3, m.home_speed = 0.3f, m.depth_most = 4, m.reserve = 0.1f;
    return m;
}

static void arming() {
    begin();
    CHECK(arm(v, true) == Refusal::not_ready);  // no attitude yet
    float_on(v, board, 100);
    for (int k = 0; k < 6; ++k) CHECK(board.pulse[k] == 0);  // nothing moves, nothing hums
    CHECK(ask_gait(v, beat()) == Refusal::disarmed);
    CHECK(ask_control(v, Control::gait) == Refusal::disarmed);
    CHECK(arm(v, true) == Refusal::none && snapshot(v).armed);
    float_on(v, board, 1);
    for (int k = 0; k < 6; ++k) CHECK_NEAR(board.pulse[k], 1500e-6, 1e-5);
    CHECK(ask_control(v, Control::mission) == Refusal::no_mission);
    CHECK(ask_control(v, Control(9)) == Refusal::unknown);
    CHECK(ask_gait(v, beat()) == Refusal::none);
    float_on(v, board, 100);
    CHECK(beats());
    CHECK(arm(v, false) == Refusal::none);  // never refused
    float_on(v, board, 300);
    for (int k = 0; k < 6; ++k) CHECK(board.pulse[k] == 0);
}

/// A command is followed to the letter or not at all.
static void commands_out_of_range() {
    begin_armed();
    const float nan = std::bit_cast<float>(0x7fc00000u);
    for (float wrong : {-0.1f, 8.1f, 1e30f, nan}) CHECK(ask_gait(v, beat(wrong)) == Refusal::out_of_range);
    Command<float> c = beat();
    c.fin[1] = 2;
    CHECK(ask_gait(v, c) == Refusal::out_of_range);
    c = beat(), c.bias[0] = nan;
    CHECK(ask_manual(v, c) == Refusal::out_of_range);
    CHECK(ask_manual(v, 1.1f, 0, 0) == Refusal::out_of_range && ask_manual(v, 0.5f, nan, 0) == Refusal::out_of_range);
    CHECK(!beats());
    CHECK(ask_manual(v, 1, -1, 0.5f) == Refusal::none);
    Mission<float> m = plan();
    way[1].speed = nan;
    CHECK(set_mission(v, m) == Refusal::out_of_range);
    way[1].speed = 0.3f;
    m.waypoints = most_waypoints + 1;
    CHECK(set_mission(v, m) == Refusal::too_many);
    CHECK(ask_control(v, Control::mission) == Refusal::no_mission);
}

/// The joystick is asked for often; a gait goes on while the ground is heard; then the tail rests, and it stays armed.
static void a_silent_ground() {
    begin_armed();
    CHECK(ask_manual(v, 1, 0, 0) == Refusal::none);
    for (int k = 0; k < 90; ++k) heard(v), float_on(v, board, 1);
    CHECK(beats());
    for (int k = 0; k < 30; ++k) heard(v), float_on(v, board, 1);
    CHECK(!beats());
    CHECK(ask_gait(v, beat()) == Refusal::none);
    for (int k = 0; k < 2000; ++k) heard(v), float_on(v, board, 1);
    CHECK(beats());
    float_on(v, board, 499);
    CHECK(beats() && !snapshot(v).faults.has(Fault::link_lost));
    float_on(v, board, 5);
    CHECK(!beats() && snapshot(v).faults.has(Fault::link_lost) && snapshot(v).armed);
    heard(v), float_on(v, board, 2);
    CHECK(beats() && !snapshot(v).faults.has(Fault::link_lost));
    // Long silence without a mission: rest, and that is remembered until it is armed anew.
    float_on(v, board, 6100);
    CHECK(snapshot(v).faults.has(Fault::link_gone) && snapshot(v).answer == Answer::home);
    heard(v), float_on(v, board, 2);
    CHECK(!beats() && snapshot(v).armed);
    arm(v, false), float_on(v, board, 2);
    CHECK(arm(v, true) == Refusal::none);
    float_on(v, board, 2);
    CHECK(!snapshot(v).faults.has(Fault::link_gone));
}

/// A mission goes on without the ground, and after the second time-out comes home.
static void silence_on_a_mission() {
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none);
    CHECK(ask_control(v, Control::mission) == Refusal::none);
    CHECK(set_mission(v, plan()) == Refusal::busy && clear_mission(v) == Refusal::busy);
    float_on(v, board, 1000);
    CHECK(snapshot(v).faults.has(Fault::link_lost) && snapshot(v).control == Control::mission);
    CHECK(!snapshot(v).reasons.has(Reason::recalled));
    float_on(v, board, 5100);
    CHECK(snapshot(v).reasons.has(Reason::recalled) && snapshot(v).reasons.end());
    // It was a gait when the ground went: the mission on board takes it home.
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && ask_gait(v, beat()) == Refusal::none);
    float_on(v, board, 6100);
    CHECK(snapshot(v).control == Control::mission && snapshot(v).reasons.has(Reason::recalled));
}

static void faults_and_answers() {
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && ask_control(v, Control::mission) == Refusal::none);
    board.raw.leak = true;
    float_on(v, board, 90);
    CHECK(!snapshot(v).faults.has(Fault::leak));
    float_on(v, board, 20);
    CHECK(snapshot(v).faults.has(Fault::leak) && snapshot(v).answer == Answer::home);
    float_on(v, board, 20);
    CHECK(snapshot(v).reasons.has(Reason::recalled));
    arm(v, false), float_on(v, board, 5);
    CHECK(arm(v, true) == Refusal::faulty);

    // On its side: the tail rests while it lies, and goes on when it stands again.
    begin_armed();
    CHECK(ask_gait(v, beat()) == Refusal::none);
    v.memory.tilted = 0;
    for (int k = 0; k < 2000; ++k) {
        heard(v);
        float_upright(board, v, int(snapshot(v).tick));
        std::swap(board.raw.channel[hypertuna::imu_channel + 4], board.raw.channel[hypertuna::imu_channel + 5]);
        tick(v, board);
    }
    CHECK(snapshot(v).faults.has(Fault::tilt) && snapshot(v).answer == Answer::rest && !beats() && snapshot(v).armed);

    // An empty battery ends it.
    begin_armed();
    CHECK(ask_gait(v, beat()) == Refusal::none);
    const hypertuna::firmware::Calibration& c = v.model.calibration;
    for (int k = 0; k < 1500; ++k) {
        heard(v);
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.channel[hypertuna::battery_channel] = {};
        board.raw.channel[hypertuna::battery_channel].add(
            std::int32_t(11.0f / c.scale[hypertuna::battery_channel] + c.zero[hypertuna::battery_channel]) + k % 3);
        tick(v, board);
    }
    CHECK(snapshot(v).faults.has(Fault::empty_battery) && !snapshot(v).armed);
    CHECK(arm(v, true) == Refusal::faulty);
    CHECK(snapshot(v).battery_left == 0);
}

static void a_watchdog_and_a_slow_tick() {
    begin();
    board.reset = true;
    boot(v, robot::description, board);
    float_on(v, board, 100);
    CHECK(snapshot(v).faults.has(Fault::watchdog) && !snapshot(v).armed && board.fed == 100);
    CHECK(arm(v, true) == Refusal::none);
    float_on(v, board, 2);
    CHECK(!snapshot(v).faults.has(Fault::watchdog) && !snapshot(v).faults.has(Fault::overrun));
    board.ticking = 400;  // of the tick's 1000, at every look at the clock
    float_on(v, board, 2);
    CHECK(snapshot(v).faults.has(Fault::overrun));
}

/// Silent or wild sensors are told, and forbid arming until they are good again.
static void sensors_fail() {
    begin();
    const auto fail = [&](int channel, int ticks) {
        for (int k = 0; k < ticks; ++k) {
            float_upright(board, v, int(snapshot(v).tick));
            board.raw.channel[channel] = {};
            tick(v, board);
        }
    };
    float_on(v, board, 100);
    const struct {
        int channel;
        Fault fault;
    } kinds[] = {{hypertuna::bend_channel + 1, Fault::bend_sensor},
                 {hypertuna::pressure_channel, Fault::pressure_sensor},
                 {hypertuna::current_channel + 3, Fault::current_sensor},
                 {hypertuna::imu_channel + 2, Fault::imu},
                 {hypertuna::battery_channel, Fault::battery_sensor}};
    for (const auto& kind : kinds) {
        fail(kind.channel, 30);
        CHECK(snapshot(v).faults.has(kind.fault));
        CHECK((arm(v, true) == Refusal::faulty) == fault_texts[int(kind.fault)].forbids);
        arm(v, false);
        float_on(v, board, 400);
        CHECK(!snapshot(v).faults.has(kind.fault));
    }
}

static void parameters_are_kept() {
    begin();
    CHECK(v.defaults);
    const int soft = index_of("pressure_soft"), hard = index_of("pressure_hard"), system = index_of("system_id");
    CHECK(soft >= 0 && hard >= 0 && system >= 0);
    CHECK(set_parameter(v, soft, 260e3f) == Refusal::out_of_range);  // a limit is never loosened
    CHECK(set_parameter(v, soft, std::bit_cast<float>(0x7fc00000u)) == Refusal::out_of_range);
    CHECK(set_parameter(v, system, 2.5f) == Refusal::out_of_range);
    CHECK(set_parameter(v, -1, 1) == Refusal::unknown && set_parameter(v, parameter_count(v), 1) == Refusal::unknown);
    CHECK(set_parameter(v, hard, 200e3f) == Refusal::inconsistent && value(v, hard) == 300e3f);
    CHECK(v.model.pilot.controller.pressure_hard == 300e3f);
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && v.model.pilot.controller.pressure_soft == 200e3f);
    CHECK(arm(v, true) == Refusal::busy);  // until it is stored
    float_on(v, board, 200);
    CHECK(arm(v, true) == Refusal::none && set_parameter(v, soft, 210e3f) == Refusal::armed);
    boot(v, robot::description, board);
    CHECK(!v.defaults && value(v, soft) == 200e3f && v.model.pilot.controller.pressure_soft == 200e3f);
    const std::uint8_t secret[key_size] = {1, 2, 3};
    CHECK(key(v) == nullptr && set_key(v, secret) == Refusal::none);
    float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(key(v) != nullptr && std::memcmp(key(v), secret, key_size) == 0);
    CHECK(value(v, soft) == 200e3f);
}

/// The black box: every tick in order, and where the card is too slow whole records are missing, no piece of one.
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

/// Under a mission the vehicle is the pilot of the core, bit for bit.
static void it_is_the_pilot_of_the_core() {
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && ask_control(v, Control::mission) == Refusal::none);
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

/// Places: one ten-millionth of a degree is 1.11 cm of latitude; the date line is no border.
static void places() {
    const Origin equator = origin_at(0, 0);
    CHECK_NEAR(local(equator, 10000000, 0).y, 110574, 2);  // WGS 84: a degree of latitude there
    CHECK_NEAR(local(equator, 0, 10000000).x, 111319, 2);
    const Origin north = origin_at(600000000, 1799999000);
    CHECK_NEAR(local(north, 600000000, -1799999000).x, 2000 * 111319e-7 * 0.5 * 1.0025, 0.02);
    CHECK_NEAR(local(north, 600010000, 1799999000).y, 111.41, 0.02);
}

/// Within a tick the extremes of three or more samples are left out; none at all is no reading.
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

int main() {
    arming();
    commands_out_of_range();
    a_silent_ground();
    silence_on_a_mission();
    faults_and_answers();
    a_watchdog_and_a_slow_tick();
    sensors_fail();
    parameters_are_kept();
    it_is_the_pilot_of_the_core();
    the_black_box();
    places();
    samples();
    CHECK(allocations == 0);
    return failures();
}
