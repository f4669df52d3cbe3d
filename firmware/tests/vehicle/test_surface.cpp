/// Tests of the robot's place after a restart and at its first fix, and of the zero of its depth.
#include "vehicle_test.hpp"

/// Reset as the watchdog does, or as a loss of power.
static void reset(bool power) {
    board.reset = power;
    if (!power) board.word = 0xa5a5a5a5;
    boot(v, robot::description, board);
}

/// A watchdog's restart at 3 m, and a loss of power there: the robot comes up by itself, and rests at the surface.
static void restart_under_water() {
    for (bool power : {true, false}) {
        begin_armed();
        CHECK(give(v, Order::gait, ground) == Refusal::none);
        board.depth = 3, contact(300);
        reset(power);
        CHECK(v.now.state == State::disarmed);
        float_on(v, board, 250);
        CHECK(v.now.state == State::surface && beats() && v.now.command.fin[0] > 0.1f);
        CHECK(v.now.faults.has(Fault::watchdog) == power);
        board.depth = 0.05f, float_on(v, board, 200);
        CHECK(v.now.state == State::rest && !beats());
        CHECK(give(v, Order::rest, ground) == Refusal::none && v.pilot == ground);
    }
    // At the surface it stays disarmed, and so does one that was disarmed and is thrown into the water later.
    for (bool armed : {true, false}) {
        if (armed)
            begin_armed();
        else
            begin(), float_on(v, board, 100);
        reset(true), float_on(v, board, 1100);
        board.depth = armed ? 0.05f : 3.0f, float_on(v, board, 500);
        CHECK(v.now.state == State::disarmed);
    }
    // Half a meter deep no air pressure tells it from the surface, but the kept word does.
    for (bool power : {true, false}) {
        begin_armed();
        board.depth = 0.5f, contact(300);
        reset(power), float_on(v, board, 250);
        CHECK(v.now.state == (power ? State::surface : State::disarmed));
    }
    // Nor does it after a loss of power, but the surface that was stored before arming does. With the ground in contact
    // the robot waits for orders: it may have been carried down from a mountain lake.
    for (bool heard : {false, true}) {
        begin(), contact(200);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        board.depth = 0.6f, contact(300);
        reset(false);
        const auto go = [&](int ticks) { heard ? contact(ticks) : float_on(v, board, ticks); };
        go(300);
        CHECK(v.now.state == State::disarmed && !v.now.estimate.zeroed);
        go(400);
        CHECK(v.now.state == (heard ? State::disarmed : State::surface));
        if (heard) {
            CHECK(give(v, Order::arm, ground) == Refusal::none && v.now.state == State::rest);
            contact(10);
            CHECK(v.now.estimate.zeroed && abs(v.now.estimate.depth) < 0.1f);
        } else {
            CHECK(beats() && v.now.command.fin[0] > 0.1f);
            board.depth = 0.05f, float_on(v, board, 200);
            CHECK(v.now.state == State::rest && !beats());
        }
    }
    // Less air than before is no water, nor is weather.
    for (float rise : {-1.5f, 0.3f}) {
        begin(), contact(200);
        board.depth += rise, reset(false), float_on(v, board, 1000);
        CHECK(v.now.state == State::disarmed && v.now.estimate.zeroed);
        const float before = v.surface;
        contact(100);
        CHECK(abs(v.surface - before - rise) < 0.02f);
    }
    // Without a depth sensor a robot that was armed ascends for as long as that takes at most.
    begin_armed(), board.depth = 3, contact(300);
    reset(true), blind(250);
    CHECK(v.now.state == State::surface && beats());
}

/// The surface: zeroed at boot, on arming near the surface and on command; kept over a reset; implausible depths do not
/// arm.
static void the_surface() {
    begin();
    board.depth = -0.25f;  // an air pressure of 989 hPa
    float_on(v, board, 300);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.02);
    board.depth = -0.10f, float_on(v, board, 300);  // it rises by 15 hPa
    CHECK_NEAR(v.now.estimate.depth, 0.15, 0.03);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 5);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
    CHECK(take_surface(v, ground) == Refusal::armed);
    board.depth = 2.9f, contact(800);
    CHECK_NEAR(v.now.estimate.depth, 3, 0.03);
    reset(true), float_on(v, board, 50);
    CHECK_NEAR(v.now.estimate.depth, 3, 0.03);
    float_on(v, board, 200);
    CHECK(v.now.state == State::surface);
    // In a tank at 1 m the zero stays.
    begin(), float_on(v, board, 300);
    board.depth = 1.05f, float_on(v, board, 2100);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK_NEAR(v.now.estimate.depth, 1, 0.03);
    // A sensor that shows no air pressure: neither armed nor zeroed there.
    begin(), board.depth = -8, float_on(v, board, 300);
    CHECK(!v.now.estimate.zeroed && give(v, Order::arm, ground) != Refusal::none);
    CHECK(take_surface(v, ground) == Refusal::no_depth);
    // On command it is zeroed by what the weather changes, not under water, whether its surface was seen or not.
    begin(), float_on(v, board, 300);
    board.depth = 0.35f, float_on(v, board, 300);
    CHECK(take_surface(v, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
    for (float depth : {0.6f, 0.8f, 3.0f}) {
        begin(), float_on(v, board, 300);
        board.depth = depth + 0.05f, float_on(v, board, 800);
        CHECK(v.now.estimate.zeroed && take_surface(v, ground) == Refusal::submerged);
        CHECK_NEAR(v.now.estimate.depth, depth, 0.03);
    }
    begin(), board.depth = 0.9f, float_on(v, board, 90);
    CHECK(!v.now.estimate.zeroed && take_surface(v, ground) == Refusal::submerged);
    // One that was carried down from a mountain, where it was zeroed, is zeroed after a restart.
    begin(), board.depth = -1.5f, contact(300);
    board.depth = 0, float_on(v, board, 800);
    CHECK(take_surface(v, ground) == Refusal::submerged);
    boot(v, robot::description, board);
    float_on(v, board, 300);
    CHECK(take_surface(v, ground) == Refusal::none);
    float_on(v, board, 10);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
}

/// The first fix sets the place of the origin. It moves neither the robot nor its mission.
static void the_first_fix() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
    contact(6000);
    const float x = v.now.estimate.x, y = v.now.estimate.y;
    CHECK(std::hypot(x, y) > 10);
    on_ground_contact(v, ground), fix(500000000, 80000000), contact(1);
    CHECK_NEAR(v.now.estimate.x, x, 0.1);
    CHECK_NEAR(v.now.estimate.y, y, 0.1);
    const auto at = local(origin(v), 500000000, 80000000);
    CHECK_NEAR(at.x, x, 0.1);
    CHECK_NEAR(at.y, y, 0.1);
    CHECK(v.mission.waypoint[0].y == -40);
    // In an origin that was given, the fix places the robot, and the place of arming with it.
    begin_armed();
    give(v, Order::disarm, ground);
    CHECK(set_origin(v, ground, 500000000, 80000000) == Refusal::none);
    float_on(v, board, 10);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    fix(500010000, 80000000), float_on(v, board, 1);
    CHECK_NEAR(v.now.estimate.y, 111.2, 0.3);
    CHECK_NEAR(v.home.y, 111.2, 0.3);
}

/// A second of floating, with one fix.
static void fix_for(int seconds, std::int32_t latitude) {
    for (int k = 0; k < seconds; ++k) on_ground_contact(v, ground), fix(latitude, 80000000), contact(99);
}

/// Fixes of another place, 2 km off, as the robot is armed: when others have agreed for half a minute, home is where it
/// was armed all the same. A home that was known stays, and so does one that was ordered.
static void the_first_fixes_are_false() {
    const MissionForm homeless{
        2, 0.3f, {{ItemKind::waypoint, local_frame, 0}, {ItemKind::waypoint, local_frame, 0}}, 0};
    const std::int32_t place = 500000000, other = place + 180000;
    const auto from_home = [] { return std::hypot(v.now.estimate.x - v.home.x, v.now.estimate.y - v.home.y); };
    for (const bool first : {true, false})
        for (const int false_for : {1, 15}) {
            begin(), float_on(v, board, 100);
            fix_for(first ? 0 : 20, place), fix_for(false_for, other);
            CHECK(set_mission(v, ground, plan(), &homeless) == Refusal::none);
            contact(200);
            CHECK(give(v, Order::arm, ground) == Refusal::none);
            fix_for(40, place);
            CHECK(!v.now.estimate.fixes_refused && from_home() < 3);
            CHECK(std::hypot(v.mission.home.x - v.home.x, v.mission.home.y - v.home.y) == 0);
        }
    begin(), float_on(v, board, 100);  // carried to another place, and armed there at once
    fix_for(40, place), fix_for(5, other);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    fix_for(40, other);
    CHECK(!v.now.estimate.fixes_refused && from_home() < 3);
    for (const bool ordered : {true, false}) {
        begin(), float_on(v, board, 100);
        fix_for(ordered ? 1 : 40, ordered ? other : place);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        if (ordered) CHECK(set_home(v, ground, {10, 20}) == Refusal::none);
        const Place home = v.home;
        fix_for(40, ordered ? place : other);
        CHECK(1900 < from_home() && v.home.x == home.x && v.home.y == home.y);
    }
}

int main() {
    restart_under_water();
    the_surface();
    the_first_fix();
    the_first_fixes_are_false();
    CHECK(allocations == 0);
    return failures();
}
