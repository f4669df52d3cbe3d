/// Tests of faults: the response to each failure.
#include "vehicle_test.hpp"

/// A mission goes on without the ground, and after the second time-out comes home.
static void silence_on_a_mission() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::none);
    CHECK(set_mission(v, ground, plan()) == Refusal::not_now && clear_mission(v, ground) == Refusal::not_now);
    float_on(v, board, 1000);
    CHECK(snapshot(v).faults.has(Fault::link_lost) && snapshot(v).state == State::mission);
    CHECK(!snapshot(v).reasons.has(Reason::recalled));
    float_on(v, board, 5100);
    CHECK(snapshot(v).reasons.has(Reason::recalled) && snapshot(v).reasons.end());
    // The robot swam a gait when the ground fell silent: the mission on board takes it home.
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
    float_on(v, board, 6100);
    CHECK(snapshot(v).state == State::home && snapshot(v).reasons.has(Reason::recalled));
}

static void faults_and_responses() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    board.raw.leak = true;
    float_on(v, board, 90);
    CHECK(!snapshot(v).faults.has(Fault::leak));
    float_on(v, board, 20);
    CHECK(snapshot(v).faults.has(Fault::leak) && snapshot(v).answer == Answer::surface);
    float_on(v, board, 20);
    CHECK(snapshot(v).state == State::rest);  // the robot is up
    give(v, Order::disarm, ground), float_on(v, board, 5);
    CHECK(give(v, Order::arm, ground) == Refusal::faulty);

    // On its side: the tail rests, and the gait is over.
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    v.memory.tilted = 0;
    for (int k = 0; k < 2000; ++k) {
        on_ground_contact(v, ground);
        float_upright(board, v, int(snapshot(v).tick));
        std::swap(board.raw.channel[hypertuna::first_channel("acceleration") + 1],
                  board.raw.channel[hypertuna::first_channel("acceleration") + 2]);
        tick(v, board);
    }
    CHECK(snapshot(v).faults.has(Fault::tilt) && snapshot(v).answer == Answer::rest && !beats());
    CHECK(snapshot(v).state == State::rest);

    // An empty battery ends the gait.
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    drain(11, 1500);
    CHECK(snapshot(v).faults.has(Fault::empty_battery) && !snapshot(v).armed());
    CHECK(give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(snapshot(v).battery_left == 0);
}

/// A low battery calls the robot home, and forbids arming; a voltage that recovers does not end that.
static void a_low_battery() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
    drain(12.5f, 1500);
    CHECK(snapshot(v).faults.has(Fault::low_battery) && !snapshot(v).faults.has(Fault::empty_battery));
    CHECK(snapshot(v).state == State::home && snapshot(v).reasons.has(Reason::recalled));
    drain(15, 500);
    CHECK(snapshot(v).faults.has(Fault::low_battery) && set_gait(v, ground, beat()) == Refusal::faulty);
    drain(12.5f, 1500), give(v, Order::disarm, ground);
    CHECK(give(v, Order::arm, ground) == Refusal::faulty);
}

/// A low battery is noticed although a loose contact hides its voltage for half of the time: after 5 s with readings by
/// the supervisor, and by the pilot of a mission.
static void a_low_battery_with_a_loose_contact() {
    for (bool mission : {false, true}) {
        begin_armed();
        if (mission) CHECK(set_mission(v, ground, plan()) == Refusal::none);
        CHECK(give(v, mission ? Order::mission : Order::rest, ground) == Refusal::none);
        for (int k = 0; k < 15; ++k) {
            drain(12.3f, 90);
            for (int lost = 0; lost < 10; ++lost) {
                on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
                board.raw.channel[hypertuna::first_channel("voltage")] = {};
                tick(v, board);
            }
        }
        CHECK(snapshot(v).faults.has(Fault::low_battery) && snapshot(v).answer == Answer::home);
        CHECK(!mission || snapshot(v).reasons.has(Reason::low_battery));
    }
}

static void a_watchdog_and_a_slow_tick() {
    begin();
    board.reset = true;
    boot(v, robot::description, board);
    float_on(v, board, 100);
    CHECK(snapshot(v).faults.has(Fault::watchdog) && !snapshot(v).armed() && board.fed == 100);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 2);
    CHECK(!snapshot(v).faults.has(Fault::watchdog) && !snapshot(v).faults.has(Fault::overrun));
    board.ticking = 400;  // of the tick's 1000, at every look at the clock
    float_on(v, board, 2);
    CHECK(snapshot(v).faults.has(Fault::overrun));
}

/// Silent or implausible sensors are reported, and forbid arming until they recover.
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
        CHECK((give(v, Order::arm, ground) == Refusal::faulty) == fault_texts[int(kind.fault)].forbids_arming);
        give(v, Order::disarm, ground);
        float_on(v, board, 400);
        CHECK(!snapshot(v).faults.has(kind.fault));
    }
}

/// Arming again clears the reason for coming home within the same tick: the robot does not set out again.
static void arming_again_after_a_call_home() {
    for (int between : {0, 5}) {
        begin();
        CHECK(set_mission(v, ground, plan()) == Refusal::none);
        float_on(v, board, 100);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        float_on(v, board, 6100);
        CHECK(snapshot(v).faults.has(Fault::link_gone) && snapshot(v).state == State::home);
        give(v, Order::disarm, ground), float_on(v, board, between);
        on_ground_contact(v, ground);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        on_ground_contact(v, ground), float_on(v, board, 3);
        CHECK(snapshot(v).armed() && snapshot(v).state == State::rest && snapshot(v).answer == Answer::warn);
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
    }
    // A battery that was empty and has recovered: the first order to arm is accepted.
    begin_armed();
    v.memory.latched.set(Fault::empty_battery, true);
    float_on(v, board, 3);
    CHECK(!snapshot(v).armed() && give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 3);
    CHECK(snapshot(v).armed());
}

/// Called home without a mission, the robot comes up slowly from deeper than rise_depth, and rests there; in a tank it
/// rests.
static void ascent_without_a_mission() {
    for (float deep : {1.2f, 3.0f}) {
        begin(), float_on(v, board, 200);
        board.depth = deep, float_on(v, board, 2100);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        float_on(v, board, 5990);
        CHECK(!beats());
        float_on(v, board, 300);
        CHECK(snapshot(v).answer == Answer::home && !v.has_mission && snapshot(v).armed());
        CHECK(beats() == (deep > 1.5f) && (snapshot(v).command.fin[0] > 0.1f) == (deep > 1.5f));
        CHECK(snapshot(v).mode == (deep > 1.5f ? Mode::home : Mode::idle));
    }
    CHECK_NEAR(snapshot(v).command.frequency, 2 * 0.25 / 0.3, 0.6);  // a slow one
    CHECK(set_gait(v, ground, beat()) == Refusal::faulty && mission(v).waypoints == 0);
    board.depth = 0.5f, float_on(v, board, 200);
    CHECK(beats());  // once it ascends it comes all the way up
    board.depth = 0.05f, float_on(v, board, 300);
    CHECK(!beats() && snapshot(v).mode == Mode::idle && snapshot(v).command.fin[0] == 0);
    board.depth = 0.25f, float_on(v, board, 300);
    CHECK(!beats());
    board.depth = 2.0f, float_on(v, board, 300);
    CHECK(beats());  // it sank
    on_ground_contact(v, ground);
    CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, Order::home, ground) == Refusal::none);
    float_on(v, board, 20);
    CHECK(snapshot(v).state == State::home && !v.on_detour);

    // A leak at depth, then loss of the depth sensor: the robot ascends for as long as the way may take, then it rests.
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.depth = 3, float_on(v, board, 200);
    board.raw.leak = true;
    const auto blind = [](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            on_ground_contact(v, ground), float_upright(board, v, int(snapshot(v).tick));
            board.raw.leak = true, board.raw.channel[hypertuna::first_channel("depth")] = {};
            tick(v, board);
        }
    };
    blind(300);
    CHECK(snapshot(v).faults.has(Fault::leak) && beats() && snapshot(v).command.fin[0] > 0.1f);
    blind(int(v.ascent_deadline - snapshot(v).tick) - 10);
    CHECK(beats() && 10'000 < snapshot(v).tick && snapshot(v).tick < 60'000);
    blind(100);
    CHECK(!beats() && v.ascent_failed && snapshot(v).state == State::rest);
    blind(1000);
    CHECK(!beats());
}

/// A robot on its back is no more upright than one on its side.
static void upside_down() {
    begin_armed();
    for (int k = 0; k < 4000; ++k) {
        on_ground_contact(v, ground);
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

int main() {
    silence_on_a_mission();
    faults_and_responses();
    a_low_battery();
    a_low_battery_with_a_loose_contact();
    a_watchdog_and_a_slow_tick();
    sensors_fail();
    arming_again_after_a_call_home();
    ascent_without_a_mission();
    upside_down();
    CHECK(allocations == 0);
    return failures();
}
