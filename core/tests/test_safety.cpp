/// Safety: plausibility, what the supervisor believes and allows, and the table of conditions.
#include <limits>

#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

static constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
static constexpr double infinite = std::numeric_limits<double>::infinity();

static void implausible_readings() {
    const Plausible<double> limits{-1, 1, 0.5, repeats_fast};
    for (double bad : {no_number, infinite, -infinite, 1.01, -1.01, 0.9}) {
        Health<double> health{};
        CHECK(judge(limits, health, 0.1, 0.0, true).usable);
        CHECK(!judge(limits, health, bad, 0.1, true).usable);  // 0.9: a step of 0.8
        CHECK(!health.faulty);                                 // one alone is no fault
    }
    Health<double> health{};
    int ticks = 0;
    while (!health.faulty && ++ticks < 100) judge(limits, health, no_number, 0.0, true);
    CHECK(ticks == 5);
    while (health.faulty && ++ticks < 1000) judge(limits, health, 0.1 + 1e-3 * (ticks % 3), 0.1, true);
    CHECK(ticks < 130);  // redeemed after a while of good readings
}

static void a_reading_is_stuck_only_where_the_robot_moves() {
    const Plausible<double> limits{-1, 1, 0.5, repeats_fast};
    Health<double> resting{}, moving{};
    int found = -1;
    for (int i = 0; i < 100; ++i) {
        CHECK(judge(limits, resting, 0.1, 0.1, false).usable);
        if (!judge(limits, moving, 0.1, 0.1, true).usable && found < 0) found = i;
    }
    CHECK(found == repeats_fast);
    CHECK(moving.faulty);
}

/// Isothermal air and a linear rest: what a circuit yields grows with the pressure, ever more slowly.
static void yielding_by_hand() {
    SupervisorModel<double> s = test_controller<double>().circuit[0];
    CHECK_NEAR(air_at(0.02, 0.0), 0.02, 1e-16);
    CHECK_NEAR(air_at(0.02, one_atmosphere), 0.01, 1e-16);
    s.soft = 0;
    CHECK_NEAR(yielded(s, one_atmosphere) - yielded(s, 0.0), 0.01, 1e-15);
    CHECK(yielded(s, 2e5) - yielded(s, 1e5) < yielded(s, 1e5) - yielded(s, 0.0));
}

/// At rest a push goes until the forecast meets the limit at one instant, and stays below it at the others.
static void the_furthest_push_meets_the_limit() {
    SupervisorModel<double> s = test_controller<double>().circuit[0];
    SupervisorState<double> now{};
    now.pressure = now.reading = 6e4;
    const double limit = 2.5e5, step = furthest(s, now, limit, 0.01), room = limit - 6e4;
    const double stiffness = room / (yielded(s, limit) - yielded(s, 6e4));
    double highest = 0;
    for (int k = 0; k < instants; ++k)
        highest = std::fmax(highest, 6e4 + step * (stiffness * s.move_by_step[k] + s.drop_by_step[k]));
    CHECK_NEAR(highest, limit, 1e-6);
    now.pressure = now.reading = 2.6e5;  // beyond it, the pump draws back
    CHECK(furthest(s, now, limit, 0.01) < 0);
    now.reading = 2.4e5;  // and is never driven back by a forecast alone
    CHECK(furthest(s, now, limit, 0.01) == 0);
}

/// Without readings no number of pushes adds up to more than the limit: the joint is taken as held fast.
static void without_readings_pushes_do_not_add_up() {
    const SupervisorModel<double> s = test_controller<double>().circuit[0];
    SupervisorState<double> now{};
    now.pressure = now.reading = 6e4;
    for (int i = 0; i < 50; ++i) {
        believe(s, now, false, no_number, 0.01, 4e4);
        now.target = std::fmin(1.0, furthest(s, now, 2.5e5, 0.01));
        const Follower<double> servo = turn_servo(s, now.servo, now.target, 0.075);
        now.moved = servo.value - now.servo.value, now.servo = servo;
    }
    CHECK(yielded(s, 6e4) + now.servo.value < yielded(s, 3e5));
    CHECK(0.01 < now.servo.value);
}

static void every_condition_has_its_text() {
    for (const ConditionText& text : condition_texts) CHECK(text.name && text.sentence && *text.sentence);
    Status status{};
    status.tell(Condition::hard_stop, 3);
    CHECK(status.has(Condition::hard_stop) && status.has(Condition::hard_stop, 3) &&
          !status.has(Condition::hard_stop, 2));
    CHECK(!status.has(Condition::blind) && conditions <= 32 && most_servos <= 16);
}

int main() {
    implausible_readings();
    a_reading_is_stuck_only_where_the_robot_moves();
    yielding_by_hand();
    the_furthest_push_meets_the_limit();
    without_readings_pushes_do_not_add_up();
    every_condition_has_its_text();
    return failures();
}
