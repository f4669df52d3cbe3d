/// Tests of the failsafes: what the robot does by itself in the water.
#include <algorithm>

#include "vehicle_test.hpp"

/// An empty battery: up first, then disarmed.
static void an_empty_battery() {
    begin_armed();
    board.depth = 3, contact(300);
    drain(11, 1500);
    CHECK(v.now.faults.has(Fault::empty_battery) && v.now.state == State::surface && beats());
    CHECK(give(v, Order::gait, ground) == Refusal::faulty && give(v, Order::home, ground) == Refusal::faulty);
    board.depth = 0.05f, drain(11, 200);
    CHECK(v.now.state == State::disarmed && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::empty_battery)].sentence) == 0 ||
          std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::low_battery)].sentence) == 0);
}

/// A dead depth sensor forbids arming, and is reported. An armed robot can be steered, but its fins only lift.
static void a_dead_depth_sensor() {
    for (float fin : {-0.4f, 0.3f}) {
        begin_armed();
        Command<float> dive = beat();
        dive.fin[0] = dive.fin[1] = fin;
        CHECK(set_gait(v, ground, dive) == Refusal::none);
        board.depth = 3, contact(300);
        CHECK(v.now.command.fin[0] == fin);
        blind(200);
        CHECK(v.now.state == State::gait && beats() && v.now.command.fin[0] == std::max(0.0f, fin));
    }
    begin();
    blind(200);
    CHECK(v.now.faults.has(Fault::depth_sensor) && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), "the depth sensor failed") == 0);
    float_on(v, board, 400);
    CHECK(!v.now.faults.has(Fault::depth_sensor) && give(v, Order::arm, ground) == Refusal::none);
}

/// Below the depth limit fins only lift, and after a second the robot comes up.
static void the_depth_limit() {
    for (Order order : {Order::manual, Order::gait}) {
        begin();
        CHECK(set_parameter(v, ground, index_of("depth_max"), 4) == Refusal::none);
        float_on(v, board, 300);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        Command<float> dive = beat();
        dive.fin[0] = dive.fin[1] = -0.4f;
        const auto repeat = [&] {
            if (order == Order::gait) return;
            sticks(v, ground, 0, 0, 0), sticks(v, ground, 0.5f, 0, -1);
        };
        if (order == Order::gait)
            CHECK(set_gait(v, ground, dive) == Refusal::none);
        else
            CHECK(give(v, order, ground) == Refusal::none);
        const auto go = [&](int ticks) {
            for (int k = 0; k < ticks; ++k) repeat(), contact(1);
        };
        board.depth = 3, go(300);
        CHECK(v.now.command.fin[0] < -0.3f && beats());
        board.depth = 3.8f, go(150);
        CHECK(v.now.command.fin[0] == 0 && beats() && v.now.answer == Answer::warn);
        board.depth = 4.4f, go(400);
        CHECK(v.now.faults.has(Fault::too_deep) && v.now.state == State::surface && v.now.command.fin[0] > 0.1f);
        CHECK(give(v, Order::gait, ground) == Refusal::faulty);
        board.depth = 0.05f, contact(300);
        CHECK(v.now.state == State::rest && !v.now.faults.has(Fault::too_deep));
        CHECK(give(v, Order::gait, ground) == Refusal::none);
    }
    begin();
    Mission<float> m = plan();
    m.depth_max = 11;
    CHECK(set_mission(v, ground, m) == Refusal::too_deep);  // than the hull's 10 m
}

/// Silence of the ground during a mission counts only where the ground could be heard, or if the mission asks for
/// contact.
static void silence_under_water() {
    const auto dive = [](int ticks) {  // the fins move the robot up and down
        for (int k = 0; k < ticks; ++k) {
            board.depth = std::max(0.05f, board.depth - 0.01f * v.now.command.fin[0]);
            float_on(v, board, 1);
        }
    };
    for (bool below : {false, true}) {
        begin_armed();
        Mission<float> m = plan();
        Waypoint<float> deep[1] = {{0, -400, 2, 0.3f, 2, 0}};
        m.waypoint = deep, m.waypoints = 1, m.silence_below = below;
        CHECK(set_mission(v, ground, m) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
        for (int k = 0; k < 9000; ++k) on_ground_contact(v, ground), dive(1);
        CHECK(board.depth > 1.5f && v.now.state == State::mission);
        dive(7000);
        CHECK(v.now.faults.has(Fault::link_gone) == below && v.now.reasons.has(Reason::recalled) == below);
        CHECK(v.now.state == (below ? State::home : State::mission));
        if (below) continue;
        CHECK(!v.now.faults.has(Fault::link_lost));
        board.depth = 0.05f, float_on(v, board, 3000);  // half a minute up is not long enough
        board.depth = 2, float_on(v, board, 3000);
        CHECK(!v.now.faults.has(Fault::link_gone));
        board.depth = 0.05f, float_on(v, board, 3300);
        CHECK(v.now.faults.has(Fault::link_gone) && v.now.state == State::home);
    }
    // A robot that the ground steers does not swim on without it, not even under water.
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.depth = 2, float_on(v, board, 600);
    CHECK(!beats() && v.now.state == State::rest);
}

/// A recalled mission never counts as done: not at home, and not later.
static void recalled_is_not_done() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK(give(v, Order::home, ground) == Refusal::none);
    for (int k = 0; k < 2000; ++k) {
        float_on(v, board, 1);
        CHECK(v.now.mode != Mode::done);
    }
    CHECK(v.now.reasons.has(Reason::recalled));
}

/// A leak brings the robot up where it is, not home; a parameter may choose otherwise, within the choices.
static void a_leak() {
    const struct {
        Answer answer;
        State state;
    } choices[] = {{Answer::warn, State::gait},
                   {Answer::home, State::home},
                   {Answer::stop, State::rest},
                   {Answer::surface, State::surface}};
    for (const auto& [answer, state] : choices) {
        choose("leak_answer", answer);
        fix(500000000, 80000000);
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        board.depth = 3, contact(300);
        board.raw.leak = true, contact(130);
        CHECK(v.now.faults.has(Fault::leak) && v.now.answer == answer && v.now.state == state);
        CHECK((set_gait(v, ground, beat()) == Refusal::none) == (answer == Answer::warn));
        CHECK((give(v, Order::home, ground) == Refusal::none) == (answer <= Answer::home));
        CHECK(give(v, Order::surface, ground) == Refusal::none && v.now.state == State::surface);
    }
    begin();
    CHECK(v.value[index_of("leak_answer")] == float(Answer::surface));  // of the description, as in the table
    for (float wrong : {4.0f, 1.5f, -1.0f})
        CHECK(set_parameter(v, ground, index_of("leak_answer"), wrong) == Refusal::out_of_range);
}

/// Water that sloshes over the probe is a leak if it is wet for more than a tenth of the time: with a half, after 10
/// wet ticks of 20 the sum grows by 10 - 1, so the 100 ticks of a second take twelve such rounds, and no more than 2.4
/// s. Rare flickers are none. A robot that was wet has to be dry for ten seconds before it may be armed.
static void a_leak_that_sloshes() {
    const auto slosh = [](int wet, int of, int ticks) {
        for (int k = 0; k < ticks; ++k) board.raw.leak = k % of < wet, contact(1);
    };
    for (int wet : {1, 10}) {
        begin_armed();
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        slosh(wet, 20, 240);
        CHECK(v.now.faults.has(Fault::leak) == (wet == 10) && (v.now.state == State::rest) == (wet == 10));
    }
    slosh(1, 20, 6000);
    CHECK(v.now.faults.has(Fault::leak));
    begin(), contact(300);
    slosh(10, 20, 300), slosh(0, 1, 10);
    CHECK(give(v, Order::arm, ground) == Refusal::faulty);
    slosh(0, 1, 1000);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
}

/// Without IMU or battery voltage the robot cannot be guarded: the ground can neither arm nor steer it.
static void unguarded() {
    const auto fail = [](int channel, int ticks) {
        for (int k = 0; k < ticks; ++k) {
            on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
            board.raw.channel[channel] = {};
            tick(v, board);
        }
    };
    for (const char* sensor : {"rate", "acceleration", "voltage"})
        for (Order order : {Order::manual, Order::gait, Order::mission}) {
            const int channel = std::strcmp(sensor, "rate") == 0           ? hypertuna::first_channel("rate")
                                : std::strcmp(sensor, "acceleration") == 0 ? hypertuna::first_channel("acceleration")
                                                                           : hypertuna::first_channel("voltage");
            begin_armed(), fix(500000000, 80000000);
            CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, order, ground) == Refusal::none);
            fail(channel, 50);
            CHECK(!v.now.faults.has(Fault::unguarded));
            fail(channel, 150);
            const bool steered = order != Order::mission;  // a mission has the pilot's own rules
            CHECK(v.now.faults.has(Fault::unguarded) == steered);
            if (!steered) continue;
            CHECK(v.now.state == State::home && v.now.answer == Answer::home);
            begin_armed(), fix(500000000, 80000000);  // a loose contact: a tenth of each second without readings
            CHECK(give(v, order, ground) == Refusal::none);
            for (int k = 0; k < 5; ++k) fail(channel, 10), contact(90);
            CHECK(v.now.faults.has(Fault::unguarded) && v.now.answer == Answer::home);
            float_on(v, board, 600);  // latched, even if the sensor recovers
            CHECK(v.now.faults.has(Fault::unguarded) && set_gait(v, ground, beat()) == Refusal::faulty);
            give(v, Order::disarm, ground), contact(200);
            CHECK(give(v, Order::arm, ground) == Refusal::none && !v.now.faults.has(Fault::unguarded));
            give(v, Order::disarm, ground), fail(channel, 150);
            CHECK(give(v, Order::arm, ground) == Refusal::faulty);
        }
}

/// A robot that sinks at rest comes up each time, and cannot be armed while it sinks; waves and hands do not count as
/// sinking.
static void it_sinks_at_rest() {
    const auto sink = [](float rate, int ticks) {
        for (int k = 0; k < ticks; ++k) board.depth += 0.01f * rate, contact(1);
    };
    for (float rate : {0.005f, 0.1f}) {
        begin_armed(), contact(100);
        sink(rate, int(35 / rate));
        CHECK(!v.now.faults.has(Fault::sinks) && v.now.state == State::rest);
        sink(rate, int(10 / rate) + 100);
        CHECK(v.now.state == State::surface && beats() && !v.now.faults.has(Fault::sinks));
        board.depth = 0.05f, contact(1500);
        CHECK(v.now.state == State::rest);
        sink(rate, int(45 / rate) + 100);
        CHECK(v.now.state == State::surface);
    }
    begin(), contact(300);
    sink(0.06f, 1500);
    CHECK(v.now.faults.has(Fault::sinks) && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::sinks)].sentence) == 0);
    for (int k = 0; k < 20; ++k) {  // it cannot be armed at any moment, wherever it has sunk to
        sink(0.06f, 100);
        CHECK(give(v, Order::arm, ground) == Refusal::faulty);
    }
    board.depth = 0.05f, contact(2100);
    CHECK(!v.now.faults.has(Fault::sinks) && give(v, Order::arm, ground) == Refusal::none);
    for (int k = 0; k < 6000; ++k) board.depth = 0.15f + 0.15f * std::sin(0.03f * float(k)), contact(1);
    CHECK(v.now.state == State::rest);
    board.depth = 0.05f, contact(200);
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.depth = 3, contact(300);
    CHECK(v.now.state == State::gait);  // a dive is no sinking
    begin_armed(), contact(100);
    for (int k = 0; k < 10; ++k) sink(0.1f, 99), board.depth += 0.001f, blind(1);  // lost readings do not hide it
    CHECK(v.now.state == State::surface);
}

/// Beat for some seconds with fixes of a robot that covers this fraction of the swum distance and drifts north [m/s];
/// return whether it reports no progress. One fix in ten is off by a jump [m].
static bool swims(float part, float drift, int seconds, float jump = 0, int accuracy = 1500) {
    float north = 0, east = 0;
    for (int k = 0; k < 100 * seconds && !v.now.faults.has(Fault::no_progress); ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        const auto& at = v.now.estimate;
        const float step = 0.01f * part * at.speed / at.factor;
        north += step * at.facing.y + 0.01f * drift, east += step * at.facing.x;
        if (k % 100 == 0) {
            board.raw.fixed = true, board.raw.accuracy = accuracy;
            const float off = k % 1000 == 900 ? jump : 0;
            board.raw.fix[0] = 500000000 + std::int32_t((north + off) / 0.0111f);
            board.raw.fix[1] = 80000000 + std::int32_t(east / (0.0111f * 0.643f));
        }
        tick(v, board), board.raw.fixed = false;
    }
    return v.now.faults.has(Fault::no_progress);
}

/// Whether a robot that circles at 0.3 m/s reports no progress within 300 s: on a leg that changes after some seconds,
/// or on none; drifting [m/s]; with fixes that the pilot takes, or refuses but for the first, all or one in ten off by
/// a jump [m]; turning [rad/s].
static bool circles(int leg, int changes, float drift, bool taken, float jump = 0, int jumps = 1, float turn = 0.2f) {
    Headway way{};
    hypertuna::Estimate<float> at{};
    hypertuna::PilotReadings<float> seen{};
    at.speed = 0.3f, at.factor = 1;
    for (int k = 0; k < 30'000; ++k) {
        const float angle = 0.01f * turn * float(k);
        at.facing = {std::cos(angle), std::sin(angle), 0};
        seen.fixed = k % 100 == 0, at.fix = seen.fixed && (taken || k == 0);
        seen.fix[0] = 1e-2f * drift * float(k) + (k > 0 && k / 100 % jumps == 0 ? jump : 0), seen.accuracy = 1.5f;
        const int on = leg < 0 ? leg : leg + k / (100 * changes);
        const SupervisorInput input{v.state.controller, v.now.output, at, seen, false, false, false, false, true,
                                    State::mission,     on,           0};
        if (makes_no_way(way, v.model.limits, input, 0.01f)) return true;
    }
    return false;
}

/// A robot that swims 60 m on one leg and stays within 7.5 m is held back, also by a line around which it circles.
/// Fixes that the pilot refuses count if they are near the last fix that it used.
static void no_progress_in_circles() {
    begin_armed();
    CHECK(circles(0, 1000, 0, true) && circles(max_waypoints, 1000, 0, true) && circles(3, 250, 0.02f, true));
    CHECK(circles(0, 1000, 0, false) && circles(0, 1000, 0, false, 50, 10));
    CHECK(!circles(-1, 1000, 0, true) && !circles(0, 150, 0, true) && !circles(0, 1000, 0.1f, true));
    CHECK(!circles(0, 1000, 0, false, 50));
    CHECK(circles(0, 40, 0, true, 0, 1, 0));  // straight, no matter on how many legs
    CHECK(set_mission(v, ground, plan()) == Refusal::none && leg_of(v) == -1);
    CHECK(give(v, Order::mission, ground) == Refusal::none);
    contact(20);
    CHECK(leg_of(v) == 0);
    CHECK(give(v, Order::home, ground) == Refusal::none);
    contact(20);
    CHECK(leg_of(v) == max_waypoints);
    v.state.guidance.mode = Mode::transit, v.state.guidance.held = 1;  // it circles at a waypoint, as it should
    CHECK(leg_of(v) == -1);
}

/// A robot that is entangled or aground does not beat until its battery is empty.
static void no_progress() {
    for (Answer answer : {Answer::warn, Answer::stop, Answer::surface}) {
        choose("snag_answer", answer);
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        CHECK(swims(0, 0, 200));
        CHECK(v.now.tick < 20'000);
        contact(10);
        CHECK(v.now.state == (answer == Answer::warn ? State::gait : State::rest));
        CHECK(beats() == (answer == Answer::warn));
    }
    choose("snag_answer", Answer::warn);  // jumps of the receiver are not progress
    CHECK(set_gait(v, ground, beat()) == Refusal::none && swims(0, 0, 200, 60));
    for (float part : {0.3f, 1.0f}) {
        choose("snag_answer", Answer::surface);
        CHECK(set_gait(v, ground, beat()) == Refusal::none && !swims(part, 0, 300));
    }
    // Fixes of 9 m, too poor for a quarter of 30 m: it is judged by 18 m, after 72 m at 0.2 m/s.
    choose("snag_answer", Answer::surface);
    CHECK(set_gait(v, ground, beat()) == Refusal::none && swims(0, 0, 400, 0, 9000));
    choose("snag_answer", Answer::surface);  // a current alone is neither progress nor loss
    CHECK(!swims(0, 0.2f, 300) && v.now.state == State::rest);
    begin();
    CHECK(set_parameter(v, ground, index_of("snag_distance"), 0) == Refusal::none);
    float_on(v, board, 300), give(v, Order::arm, ground);
    CHECK(set_gait(v, ground, beat()) == Refusal::none && !swims(0, 0, 300));
}

int main() {
    an_empty_battery();
    a_dead_depth_sensor();
    the_depth_limit();
    a_leak();
    a_leak_that_sloshes();
    unguarded();
    it_sinks_at_rest();
    no_progress();
    no_progress_in_circles();
    silence_under_water();
    recalled_is_not_done();
    CHECK(allocations == 0);
    return failures();
}
