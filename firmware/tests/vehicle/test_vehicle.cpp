/// The vehicle: who may ask for what, what each failure leads to, and that it adds nothing to the pilot of the core.
#include "../../../core/tests/allocations.hpp"
#include "../../../core/tests/check.hpp"
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
    CHECK(set_gait(v, beat()) == Refusal::disarmed);
    CHECK(set_control(v, Control::gait) == Refusal::disarmed);
    CHECK(arm(v, true) == Refusal::none && snapshot(v).armed);
    float_on(v, board, 1);
    for (int k = 0; k < 6; ++k) CHECK_NEAR(board.pulse[k], 1500e-6, 1e-5);
    CHECK(set_control(v, Control::mission) == Refusal::no_mission);
    CHECK(set_control(v, Control(9)) == Refusal::unknown);
    CHECK(set_gait(v, beat()) == Refusal::none);
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
    for (float wrong : {-0.1f, 8.1f, 1e30f, nan}) CHECK(set_gait(v, beat(wrong)) == Refusal::out_of_range);
    Command<float> c = beat();
    c.fin[1] = 2;
    CHECK(set_gait(v, c) == Refusal::out_of_range);
    c = beat(), c.bias[0] = nan;
    CHECK(set_manual(v, c) == Refusal::out_of_range);
    CHECK(set_manual(v, 1.1f, 0, 0) == Refusal::out_of_range && set_manual(v, 0.5f, nan, 0) == Refusal::out_of_range);
    CHECK(!beats());
    CHECK(set_manual(v, 1, -1, 0.5f) == Refusal::none);
    Mission<float> m = plan();
    way[1].speed = nan;
    CHECK(set_mission(v, m) == Refusal::out_of_range);
    way[1].speed = 0.3f;
    m.waypoints = max_waypoints + 1;
    CHECK(set_mission(v, m) == Refusal::too_many);
    CHECK(set_control(v, Control::mission) == Refusal::no_mission);
}

/// The joystick is asked for often; a gait goes on while the ground is heard; then the tail rests, and it stays armed.
static void a_silent_ground() {
    begin_armed();
    CHECK(set_manual(v, 1, 0, 0) == Refusal::none);
    for (int k = 0; k < 90; ++k) on_ground_contact(v), float_on(v, board, 1);
    CHECK(beats());
    for (int k = 0; k < 30; ++k) on_ground_contact(v), float_on(v, board, 1);
    CHECK(!beats());
    CHECK(set_gait(v, beat()) == Refusal::none);
    for (int k = 0; k < 2000; ++k) on_ground_contact(v), float_on(v, board, 1);
    CHECK(beats());
    float_on(v, board, 499);
    CHECK(beats() && !snapshot(v).faults.has(Fault::link_lost));
    float_on(v, board, 5);
    CHECK(!beats() && snapshot(v).faults.has(Fault::link_lost) && snapshot(v).armed);
    on_ground_contact(v), float_on(v, board, 2);
    CHECK(beats() && !snapshot(v).faults.has(Fault::link_lost));
    // Long silence without a mission: rest, and that is origin_restored until it is armed anew.
    float_on(v, board, 6100);
    CHECK(snapshot(v).faults.has(Fault::link_gone) && snapshot(v).answer == Answer::home);
    on_ground_contact(v), float_on(v, board, 2);
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
    CHECK(set_control(v, Control::mission) == Refusal::none);
    CHECK(set_mission(v, plan()) == Refusal::busy && clear_mission(v) == Refusal::busy);
    float_on(v, board, 1000);
    CHECK(snapshot(v).faults.has(Fault::link_lost) && snapshot(v).control == Control::mission);
    CHECK(!snapshot(v).reasons.has(Reason::recalled));
    float_on(v, board, 5100);
    CHECK(snapshot(v).reasons.has(Reason::recalled) && snapshot(v).reasons.end());
    // It was a gait when the ground went: the mission on board takes it home.
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && set_gait(v, beat()) == Refusal::none);
    float_on(v, board, 6100);
    CHECK(snapshot(v).control == Control::mission && snapshot(v).reasons.has(Reason::recalled));
}

static void faults_and_answers() {
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
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
    CHECK(set_gait(v, beat()) == Refusal::none);
    v.memory.tilted = 0;
    for (int k = 0; k < 2000; ++k) {
        on_ground_contact(v);
        float_upright(board, v, int(snapshot(v).tick));
        std::swap(board.raw.channel[hypertuna::first_channel("acceleration") + 1],
                  board.raw.channel[hypertuna::first_channel("acceleration") + 2]);
        tick(v, board);
    }
    CHECK(snapshot(v).faults.has(Fault::tilt) && snapshot(v).answer == Answer::rest && !beats() && snapshot(v).armed);

    // An empty battery ends it.
    begin_armed();
    CHECK(set_gait(v, beat()) == Refusal::none);
    const hypertuna::firmware::Calibration& c = v.model.calibration;
    for (int k = 0; k < 1500; ++k) {
        on_ground_contact(v);
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.channel[hypertuna::first_channel("voltage")] = {};
        board.raw.channel[hypertuna::first_channel("voltage")].add(
            std::int32_t(11.0f / c.scale[hypertuna::first_channel("voltage")] +
                         c.zero[hypertuna::first_channel("voltage")]) +
            k % 3);
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
    } kinds[] = {{hypertuna::first_channel("bend") + 1, Fault::bend_sensor},
                 {hypertuna::first_channel("pressure"), Fault::pressure_sensor},
                 {hypertuna::first_channel("current") + 3, Fault::current_sensor},
                 {hypertuna::first_channel("rate") + 2, Fault::imu},
                 {hypertuna::first_channel("voltage"), Fault::battery_sensor}};
    for (const auto& kind : kinds) {
        fail(kind.channel, 30);
        CHECK(snapshot(v).faults.has(kind.fault));
        CHECK((arm(v, true) == Refusal::faulty) == fault_texts[int(kind.fault)].forbids_arming);
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

/// Arming anew forgets what called it home, in the same tick already: it does not set out once more.
static void arming_anew_after_a_call_home() {
    for (int between : {0, 5}) {
        begin();
        CHECK(set_mission(v, plan()) == Refusal::none);
        float_on(v, board, 100);
        CHECK(arm(v, true) == Refusal::none);
        float_on(v, board, 6100);
        CHECK(snapshot(v).faults.has(Fault::link_gone) && snapshot(v).control == Control::mission);
        arm(v, false), float_on(v, board, between);
        on_ground_contact(v);
        CHECK(arm(v, true) == Refusal::none);
        on_ground_contact(v), float_on(v, board, 3);
        CHECK(snapshot(v).armed && snapshot(v).control == Control::gait && snapshot(v).answer == Answer::warn);
        CHECK(set_gait(v, beat()) == Refusal::none);
    }
    // A battery that was empty, and is not any more: the first order to arm counts.
    begin_armed();
    v.memory.latched.set(Fault::empty_battery, true);
    float_on(v, board, 3);
    CHECK(!snapshot(v).armed && arm(v, true) == Refusal::none);
    float_on(v, board, 3);
    CHECK(snapshot(v).armed);
}

/// What is called home follows nobody else: an order is refused, and does not begin the way home anew.
static void orders_on_the_way_home() {
    begin_armed();
    CHECK(set_mission(v, plan()) == Refusal::none && set_gait(v, beat()) == Refusal::none);
    float_on(v, board, 6200);
    const int ticks = v.state.guidance.ticks;
    for (int k = 0; k < 100; ++k) {
        on_ground_contact(v);
        CHECK(set_manual(v, 0.5f, 0, 0) == Refusal::faulty && set_gait(v, beat()) == Refusal::faulty);
        CHECK(set_control(v, Control::gait) == Refusal::faulty);
        CHECK(set_control(v, Control::mission) == Refusal::none);
        float_on(v, board, 1);
    }
    CHECK(v.state.guidance.ticks >= ticks + 9 && snapshot(v).control == Control::mission);
    CHECK(arm(v, false) == Refusal::none);
}

/// A mission with its fence, every number of it another one than those of the other.
static Mission<float> numbered(int which) {
    static Waypoint<float> to[max_waypoints];
    static hypertuna::Corner<float> corner[max_corners];
    Mission<float> m = plan();
    m.waypoint = to, m.corner = corner;
    m.waypoints = 3 + 40 * which, m.corners = 4 + which, m.stay = which == 1;
    m.home = {1.0f + float(which), 2.0f + float(which)}, m.reserve = 0.2f + 0.1f * float(which);
    for (int k = 0; k < m.waypoints; ++k)
        to[k] = {float(k + which), float(2 * k - which), 1.0f + float(which), 0.3f, 2.0f + float(which)};
    for (int k = 0; k < m.corners; ++k) corner[k] = {float(50 * k + which), float(k * k + which)};
    return m;
}

static bool same(const Mission<float>& a, const Mission<float>& b) {
    return a.waypoints == b.waypoints && a.corners == b.corners && a.stay == b.stay && a.home.x == b.home.x &&
           a.home.y == b.home.y && a.reserve == b.reserve && a.depth_most == b.depth_most &&
           std::memcmp(a.waypoint, b.waypoint, sizeof(a.waypoint[0]) * std::size_t(a.waypoints)) == 0 &&
           std::memcmp(a.corner, b.corner, sizeof(a.corner[0]) * std::size_t(a.corners)) == 0;
}

/// Called home without a mission: from deeper than rise_depth it comes up, slowly, and rests there; in a tank it rests.
static void up_without_a_mission() {
    for (float deep : {1.2f, 3.0f}) {
        begin_armed();
        board.depth = deep;
        float_on(v, board, 5990);
        CHECK(!beats());
        float_on(v, board, 300);
        CHECK(snapshot(v).answer == Answer::home && !v.has_mission && snapshot(v).armed);
        CHECK(beats() == (deep > 1.5f) && (snapshot(v).command.fin[0] > 0.1f) == (deep > 1.5f));
        CHECK(snapshot(v).mode == (deep > 1.5f ? Mode::home : Mode::idle));
    }
    CHECK_NEAR(snapshot(v).command.frequency, 2 * 0.25 / 0.3, 0.6);  // a slow one
    CHECK(set_gait(v, beat()) == Refusal::faulty && mission(v).waypoints == 0);
    board.depth = 0.5f, float_on(v, board, 200);
    CHECK(beats());  // once on its way it comes up
    board.depth = 0.05f, float_on(v, board, 300);
    CHECK(!beats() && snapshot(v).mode == Mode::idle && snapshot(v).command.fin[0] == 0);
    board.depth = 1.0f, float_on(v, board, 300);
    CHECK(!beats());
    board.depth = 2.0f, float_on(v, board, 300);
    CHECK(beats());  // it sank
    on_ground_contact(v);
    CHECK(set_mission(v, plan()) == Refusal::none);  // then that is the way home
    float_on(v, board, 20);
    CHECK(snapshot(v).control == Control::mission && v.ascent == Ascent::none);

    // A leak at depth, and the depth cannot be read any more: up for as long as the way may take, then it rests.
    begin_armed();
    board.depth = 3, float_on(v, board, 200);
    board.raw.leak = true;
    const auto blind = [](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            on_ground_contact(v), float_upright(board, v, int(snapshot(v).tick));
            board.raw.leak = true, board.raw.channel[hypertuna::first_channel("depth")] = {};
            tick(v, board);
        }
    };
    blind(300);
    CHECK(snapshot(v).faults.has(Fault::leak) && beats() && snapshot(v).command.fin[0] > 0.1f);
    blind(int(v.ascent_deadline - snapshot(v).tick) - 10);
    CHECK(beats() && 10'000 < snapshot(v).tick && snapshot(v).tick < 60'000);
    blind(100);
    CHECK(!beats() && v.ascent == Ascent::failed && snapshot(v).armed);
    blind(1000);
    CHECK(!beats());
}

/// A mission from before the restart may be of another water, and a tank has no fixes that tell: it is no way home
/// until the ground begins it or sends it anew.
static void a_kept_mission_is_no_way_home() {
    for (bool begun : {false, true}) {
        begin();
        set_mission(v, numbered(1)), float_on(v, board, 300);
        boot(v, robot::description, board);
        float_on(v, board, 100);
        CHECK(arm(v, true) == Refusal::none);
        if (begun) CHECK(set_control(v, Control::mission) == Refusal::none && set_gait(v, beat()) == Refusal::none);
        float_on(v, board, 6200);
        CHECK(snapshot(v).answer == Answer::home && beats() == begun);
        CHECK((snapshot(v).control == Control::mission) == begun);
        board.depth = 3, float_on(v, board, 300);  // but up it comes
        CHECK(beats() && same(mission(v), numbered(1)));
    }
}

/// A parameter that is set changes its own field alone, and all others are what they were.
static void one_field_is_filled() {
    begin();
    static Model filled;
    for (int k = 0; k < parameter_count(v); ++k) {
        const ParameterInfo& info = parameter(v, k);
        const float to = info.low + (info.whole ? 0.0f : 0.4f) * (info.high - info.low);
        set_parameter(v, k, to);
    }
    std::memcpy(&filled, &v.model, sizeof filled);
    configure(filled, robot::description, v.value);
    CHECK(std::memcmp(&filled, &v.model, sizeof filled) == 0);
}

/// On its back it is no more upright than on its side.
static void upside_down() {
    begin_armed();
    for (int k = 0; k < 4000; ++k) {
        on_ground_contact(v);
        float_upright(board, v, int(snapshot(v).tick));
        for (int axis : {1, 2}) {
            auto& raw = board.raw.channel[hypertuna::first_channel("acceleration") + axis];
            raw.sum = -raw.sum, raw.min = raw.max = raw.sum;
            auto& field = board.raw.channel[hypertuna::first_channel("field") + axis];
            field.sum = -field.sum, field.min = field.max = field.sum;
        }
        tick(v, board);
    }
    CHECK(snapshot(v).faults.has(Fault::tilt) && snapshot(v).answer == Answer::rest);
}

/// A joystick asks for a part of what is allowed: where a limit was made tighter, of less. Let go of, the tail is
/// straight.
static void joystick_within_tighter_limits() {
    begin();
    for (const char* name : {"amplitude_0", "amplitude_1", "fin_max", "frequency_max"})
        CHECK(set_parameter(v, index_of(name), 0.5f * value(v, index_of(name))) == Refusal::none);
    float_on(v, board, 300);
    CHECK(arm(v, true) == Refusal::none);
    CHECK(set_manual(v, 1, 1, 1) == Refusal::none);
    CHECK(within(v.model.pilot.controller, v.requested) && v.requested.amplitude[0] > 0.05f &&
          v.requested.fin[0] > 0.5f);
    CHECK(set_manual(v, 0, 0, 0) == Refusal::none && v.requested.amplitude[0] == 0 && v.requested.amplitude[1] == 0);
    CHECK(set_manual(v, 0, 1, 0) == Refusal::none && v.requested.amplitude[0] == 0 && abs(v.requested.bias[0]) > 0.05f);
}

/// What is stored counts only if every value is within its range now: a description may have become stricter.
static void stored_parameters_out_of_range() {
    const float nan = std::bit_cast<float>(0x7fc00000u);
    for (float stored : {nan, 1e9f, 249e3f}) {
        begin();
        const int soft = index_of("pressure_soft");
        std::memcpy(v.stored + 4 * soft, &stored, 4);
        begin_write(v.store), float_on(v, board, 200);
        boot(v, robot::description, board);
        const bool good = stored == 249e3f;
        CHECK(value(v, soft) == (good ? stored : 250e3f) && v.defaults != good);
        CHECK(v.model.pilot.controller.pressure_soft == value(v, soft));
    }
    begin();  // each in its range, but not together
    const float soft = 250e3f, hard = 200e3f;
    std::memcpy(v.stored + 4 * index_of("pressure_soft"), &soft, 4);
    std::memcpy(v.stored + 4 * index_of("pressure_hard"), &hard, 4);
    begin_write(v.store), float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(v.defaults && v.model.pilot.controller.pressure_hard == 300e3f);
}

/// A fence of two corners is none, and one of both kinds is not one that the pilot keeps.
static void fences() {
    begin();
    static const hypertuna::Corner<float> corner[3] = {{-50, -50}, {50, -50}, {0, 90}};
    Mission<float> m = plan();
    m.corner = corner;
    for (int corners : {1, 2}) m.corners = corners, CHECK(set_mission(v, m) == Refusal::out_of_range);
    m.corners = 3, m.range = 100;
    CHECK(set_mission(v, m) == Refusal::out_of_range);
    m.range = 0;
    CHECK(set_mission(v, m) == Refusal::none);
    CHECK(set_origin(v, 0, 1800000001) == Refusal::out_of_range);
    CHECK(set_origin(v, 0, INT32_MIN) == Refusal::out_of_range);
}

/// A mission survives a restart, as a whole, and so does that there is none.
static void missions_are_kept() {
    begin();
    float_on(v, board, 100);
    CHECK(set_mission(v, numbered(1)) == Refusal::none);
    float_on(v, board, 10);
    CHECK(arm(v, true) == Refusal::busy);  // until it is stored
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(v.has_mission && same(mission(v), numbered(1)));
    float_on(v, board, 100);
    CHECK(arm(v, true) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
    CHECK(set_control(v, Control::gait) == Refusal::none && set_mission(v, numbered(0)) == Refusal::none);
    static MemoryBoard before;
    before = board;
    float_on(v, board, 300);  // not written while armed
    CHECK(std::memcmp(before.memory, board.memory, sizeof(board.memory)) == 0 && !settled(v.missions));
    arm(v, false), float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(same(mission(v), numbered(0)));
    CHECK(clear_mission(v) == Refusal::none);
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(!v.has_mission && mission(v).waypoints == 0);
}

/// What is stored must be sound today.
static void stored_missions_out_of_range() {
    const auto stored = [](auto spoil) {
        begin();
        CHECK(set_mission(v, numbered(1)) == Refusal::none);
        spoil(v.plan), float_on(v, board, 300);
        boot(v, robot::description, board);
        return v.has_mission;
    };
    CHECK(stored([](StoredMission&) {}));
    CHECK(!stored([](StoredMission& m) { m.waypoint[2].speed = std::bit_cast<float>(0x7fc00000u); }));
    CHECK(!stored([](StoredMission& m) { m.waypoints = max_waypoints + 1; }));
    CHECK(!stored([](StoredMission& m) { m.corners = -1; }));
    CHECK(!stored([](StoredMission& m) { m.has_origin = 1, m.latitude = INT32_MIN; }));
}

/// Cut the power at every byte of a mission's write: it boots with the old one or the new one.
static void power_cuts_of_a_mission() {
    begin();
    set_mission(v, numbered(0)), float_on(v, board, 300);
    static MemoryBoard first;
    first = board;
    int old_ones = 0, new_ones = 0;
    for (int cut = 0; cut <= 4 + slot_head + int(sizeof(StoredMission)); ++cut) {
        board = first;
        boot(v, robot::description, board);
        CHECK(set_mission(v, numbered(1)) == Refusal::none);
        board.power = cut, board.torn = 0x5a;
        for (int k = 0; k < 300; ++k) write_stores(v, board);
        board.power = -1;
        boot(v, robot::description, board);
        const bool is_old = v.has_mission && same(mission(v), numbered(0));
        const bool is_new = v.has_mission && same(mission(v), numbered(1));
        CHECK(is_old != is_new);
        old_ones += is_old, new_ones += is_new;
    }
    CHECK(old_ones > 1500 && new_ones > 0);
    std::printf("power cuts of a mission: %d, old %d, new %d\n", old_ones + new_ones, old_ones, new_ones);
}

/// Places of a kept mission count from the origin that it had, wherever the robot boots.
static void a_kept_mission_has_its_place() {
    const auto fix = [](std::int32_t latitude, std::int32_t longitude) {
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.fixed = true, board.raw.fix[0] = latitude, board.raw.fix[1] = longitude;
        tick(v, board);
        board.raw.fixed = false;
    };
    begin();
    float_on(v, board, 50);
    CHECK(set_mission(v, numbered(1)) == Refusal::none);  // before there is a fix
    fix(500000000, 80000000);
    float_on(v, board, 300);
    CHECK(set_origin(v, 500000000, 80000001) == Refusal::elsewhere);
    CHECK(set_origin(v, 500000000, 80000000) == Refusal::none);

    boot(v, robot::description, board);  // 111.2 m to the north
    CHECK(v.has_mission && origin(v).known && origin(v).latitude == 500000000);
    float_on(v, board, 50);
    fix(500010000, 80000000);
    float_on(v, board, 2);
    CHECK(origin(v).latitude == 500000000);
    CHECK_NEAR(snapshot(v).estimate.y, 111.2, 0.2);

    boot(v, robot::description, board);  // a hundred kilometers away: another lake
    float_on(v, board, 100);
    CHECK(arm(v, true) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
    float_on(v, board, 100);
    fix(510000000, 80000000);
    CHECK(!v.has_mission && origin(v).latitude == 510000000 && snapshot(v).control == Control::gait);
    float_on(v, board, 100);
    CHECK(!beats() && snapshot(v).armed);
    CHECK(set_control(v, Control::mission) != Refusal::none);
    boot(v, robot::description, board);  // and back again
    CHECK(v.has_mission);
}

/// The same value once more is not written once more, and memory that does not hold is told.
static void the_memory_wears() {
    begin();
    const int soft = index_of("pressure_soft");
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && !settled(v.store));
    float_on(v, board, 200);
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && settled(v.store));
    board.worn = int(~v.store.turn & 1) * (slot_head + v.store.size);  // a byte of the next mark
    CHECK(set_parameter(v, soft, 201e3f) == Refusal::none);
    float_on(v, board, 200);
    CHECK(snapshot(v).faults.has(Fault::memory));
    board.worn = -1;
    CHECK(set_parameter(v, soft, 201e3f) == Refusal::none && !settled(v.store));  // once more
    float_on(v, board, 200);
    CHECK(!snapshot(v).faults.has(Fault::memory));
}

/// A ring that is full to the last word keeps what is in it.
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
    CHECK(set_mission(v, plan()) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
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
    CHECK(is_place(-899999999, 1800000000) && !is_place(INT32_MIN, 0) && !is_place(0, INT32_MAX));
    CHECK(abs(local(north, INT32_MIN, INT32_MAX).y) > 1e6f);  // no place at all, and no overflow
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
    arming_anew_after_a_call_home();
    orders_on_the_way_home();
    up_without_a_mission();
    a_kept_mission_is_no_way_home();
    one_field_is_filled();
    upside_down();
    joystick_within_tighter_limits();
    stored_parameters_out_of_range();
    fences();
    missions_are_kept();
    stored_missions_out_of_range();
    power_cuts_of_a_mission();
    a_kept_mission_has_its_place();
    the_memory_wears();
    a_full_ring();
    the_black_box();
    places();
    samples();
    CHECK(allocations == 0);
    return failures();
}
