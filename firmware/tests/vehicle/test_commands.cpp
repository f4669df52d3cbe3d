/// Tests of commands: which are accepted, which are refused, and how long they last.
#include "vehicle_test.hpp"

static void arming() {
    begin();
    CHECK(give(v, Order::arm, ground) == Refusal::not_ready);  // no attitude yet
    float_on(v, board, 100);
    for (int k = 0; k < 6; ++k) CHECK(board.pulse[k] == 0);  // nothing moves, nothing hums
    CHECK(set_gait(v, ground, beat()) == Refusal::disarmed);
    CHECK(give(v, Order::gait, ground) == Refusal::disarmed);
    CHECK(give(v, Order::arm, ground) == Refusal::none && snapshot(v).armed());
    float_on(v, board, 1);
    for (int k = 0; k < 6; ++k) CHECK_NEAR(board.pulse[k], 1500e-6, 1e-5);
    CHECK(give(v, Order::mission, ground) == Refusal::no_mission);
    CHECK(give(v, Order::count, ground) == Refusal::unknown && give(v, Order::recall, ground) == Refusal::unknown);
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    float_on(v, board, 100);
    CHECK(beats());
    CHECK(give(v, Order::disarm, ground) == Refusal::none);  // never refused
    float_on(v, board, 300);
    for (int k = 0; k < 6; ++k) CHECK(board.pulse[k] == 0);
}

/// A command is followed exactly or not at all.
static void commands_out_of_range() {
    begin_armed();
    const float nan = std::bit_cast<float>(0x7fc00000u);
    for (float wrong : {-0.1f, 8.1f, 1e30f, nan}) CHECK(set_gait(v, ground, beat(wrong)) == Refusal::out_of_range);
    Command<float> c = beat();
    c.fin[1] = 2;
    CHECK(set_gait(v, ground, c) == Refusal::out_of_range);
    c = beat(), c.bias[0] = nan;
    CHECK(set_gait(v, ground, c) == Refusal::out_of_range && snapshot(v).state == State::rest);
    CHECK(sticks(v, ground, 0, 0, 0) == Refusal::not_now && give(v, Order::manual, ground) == Refusal::none);
    CHECK(sticks(v, ground, 1.1f, 0, 0) == Refusal::out_of_range);
    CHECK(sticks(v, ground, 0.5f, nan, 0) == Refusal::out_of_range);
    CHECK(!beats());
    CHECK(sticks(v, ground, 1, -1, 0.5f) == Refusal::not_centered);
    CHECK(sticks(v, ground, 0, 0, 0) == Refusal::none && sticks(v, ground, 1, -1, 0.5f) == Refusal::none);
    Mission<float> m = plan();
    way[1].speed = nan;
    CHECK(set_mission(v, ground, m) == Refusal::out_of_range);
    way[1].speed = 0.3f;
    m.waypoints = max_waypoints + 1;
    CHECK(set_mission(v, ground, m) == Refusal::too_many);
    CHECK(give(v, Order::mission, ground) == Refusal::no_mission);
}

/// The joystick must repeat its commands; a gait continues while the ground is in contact; then the tail rests, and the
/// robot stays armed.
static void a_silent_ground() {
    begin_armed();
    CHECK(give(v, Order::manual, ground) == Refusal::none && sticks(v, ground, 0, 0, 0) == Refusal::none);
    CHECK(sticks(v, ground, 1, 0, 0) == Refusal::none);
    for (int k = 0; k < 90; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
    CHECK(beats());
    for (int k = 0; k < 30; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
    CHECK(!beats());
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    for (int k = 0; k < 2000; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
    CHECK(beats());
    float_on(v, board, 499);
    CHECK(beats() && !snapshot(v).faults.has(Fault::link_lost));
    float_on(v, board, 5);
    CHECK(!beats() && snapshot(v).faults.has(Fault::link_lost) && snapshot(v).state == State::rest);
    on_ground_contact(v, ground), float_on(v, board, 2);
    CHECK(!beats() && !snapshot(v).faults.has(Fault::link_lost));  // until it is ordered again
    // Long silence without a mission: the robot rests until it is armed again.
    float_on(v, board, 6100);
    CHECK(snapshot(v).faults.has(Fault::link_gone) && snapshot(v).answer == Answer::home);
    on_ground_contact(v, ground), float_on(v, board, 2);
    CHECK(!beats() && snapshot(v).armed());
    give(v, Order::disarm, ground), float_on(v, board, 2);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 2);
    CHECK(!snapshot(v).faults.has(Fault::link_gone));
}

/// A robot that is called home follows no other order: it is refused, and does not begin the way home again.
static void commands_on_the_way_home() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
    float_on(v, board, 6200);
    const int ticks = v.state.guidance.ticks;
    for (int k = 0; k < 100; ++k) {
        on_ground_contact(v, ground);
        CHECK(sticks(v, ground, 0.5f, 0, 0) == Refusal::not_now && set_gait(v, ground, beat()) == Refusal::faulty);
        for (Order order : {Order::gait, Order::manual, Order::rest, Order::mission})
            CHECK(give(v, order, ground) == Refusal::faulty);
        CHECK(give(v, Order::home, ground) == Refusal::none);
        float_on(v, board, 1);
    }
    CHECK(v.state.guidance.ticks >= ticks + 9 && snapshot(v).state == State::home);
    CHECK(give(v, Order::disarm, ground) == Refusal::none);
}

/// The joystick commands a fraction of the allowed amplitude, which a tighter limit reduces. When it is released, the
/// tail is straight.
static void joystick_within_tighter_limits() {
    begin();
    for (const char* name : {"amplitude_0", "amplitude_1", "fin_max", "frequency_max"})
        CHECK(set_parameter(v, ground, index_of(name), 0.5f * value(v, index_of(name))) == Refusal::none);
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    CHECK(give(v, Order::manual, ground) == Refusal::none && sticks(v, ground, 0, 0, 0) == Refusal::none);
    CHECK(sticks(v, ground, 1, 1, 1) == Refusal::none);
    CHECK(within(v.model.pilot.controller, v.requested) && v.requested.amplitude[0] > 0.05f &&
          v.requested.fin[0] > 0.3f);
    CHECK(sticks(v, ground, 0, 0, 0) == Refusal::none && v.requested.amplitude[0] == 0 &&
          v.requested.amplitude[1] == 0);
    CHECK(sticks(v, ground, 0, 1, 0) == Refusal::none && v.requested.amplitude[0] == 0 &&
          abs(v.requested.bias[0]) > 0.05f);
}

/// A fence of two corners is refused, and so is one of both kinds, which the pilot does not keep.
static void fences() {
    begin();
    static const hypertuna::Corner<float> corner[3] = {{-90, -90}, {90, -90}, {0, 90}};
    Mission<float> m = plan();
    m.corner = corner;
    for (int corners : {1, 2}) m.corners = corners, CHECK(set_mission(v, ground, m) == Refusal::out_of_range);
    m.corners = 3, m.range = 100;
    CHECK(set_mission(v, ground, m) == Refusal::out_of_range);
    m.range = 0;
    CHECK(set_mission(v, ground, m) == Refusal::none);
    CHECK(set_origin(v, ground, 0, 1800000001) == Refusal::out_of_range);
    CHECK(set_origin(v, ground, 0, INT32_MIN) == Refusal::out_of_range);
}

/// An origin far from the robot's fixes is refused, and changes nothing; a near one moves the coordinates along.
static void origins() {
    begin();
    float_on(v, board, 50);
    CHECK(set_origin(v, ground, 0, 0) == Refusal::none);  // the first fix will tell
    begin();
    float_on(v, board, 50), fix(500000000, 80000000), float_on(v, board, 1);
    const Origin before = origin(v);
    const float x = here(v).x, y = here(v).y;
    for (std::int32_t north : {2'000'000, -2'000'000, 300'000'000})  // 22 km and more
        CHECK(set_origin(v, ground, 500000000 + north, 80000000) == Refusal::far_origin);
    CHECK(set_origin(v, ground, 0, 0) == Refusal::far_origin);
    CHECK(origin(v).latitude == before.latitude && here(v).x == x && here(v).y == y);
    CHECK(set_origin(v, ground, before.latitude + 100'000, before.longitude) == Refusal::none);
    CHECK_NEAR(here(v).y, y - 1112, 1);
    float_on(v, board, 100);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    CHECK(set_origin(v, ground, before.latitude, before.longitude) == Refusal::armed);
}

int main() {
    origins();
    arming();
    commands_out_of_range();
    a_silent_ground();
    commands_on_the_way_home();
    joystick_within_tighter_limits();
    fences();
    CHECK(allocations == 0);
    return failures();
}
