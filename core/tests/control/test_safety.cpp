/// Safety: plausibility, how wide and how far the supervisor lets a joint go, and the table of conditions.
#include <cmath>
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
        CHECK(!health.faulty);                                 // a single bad reading is no fault
    }
    Health<double> health{};
    int ticks = 0;
    while (!health.faulty && ++ticks < 100) judge(limits, health, no_number, 0.0, true);
    CHECK(ticks == 5);
    while (health.faulty && ++ticks < 1000) judge(limits, health, 0.1 + 1e-3 * (ticks % 3), 0.1, true);
    CHECK(ticks < 130);  // usable again after a while of good readings
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

/// Readings of a slow robot repeat more often before they count as stuck: the motion since the last change counts, not
/// the time.
static void a_slow_sensor_is_stuck_as_soon_as_the_robot_moved_as_far() {
    const Plausible<double> limits{-1, 1, 0.5, repeats_fast};
    for (double motion : {1.0, 0.5, 0.125}) {
        Health<double> health{};
        int count = 0;
        while (judge(limits, health, 0.1, 0.1, motion).usable && count < 1000) ++count;
        CHECK(count == int(repeats_fast / motion));
    }
}

/// A contradiction makes a reading a fault, just like NaN.
static void a_contradicted_sensor_is_faulty() {
    Health<double> health{};
    int ticks = 0;
    while (!health.faulty && ++ticks < 100)
        judge(Plausible<double>{-1, 1, 0.5, repeats_fast}, health, 0.1 + 1e-3 * (ticks % 3), 0.1, 1, false);
    CHECK(ticks == 5);
}

/// Below the soft limit a pump may go anywhere; beyond it, it is sent back by the angle that removes the excess
/// pressure: 0.015 rad for 50 kPa. In a long line whose hammer takes 1 MPa for 1 rad/s, by 0.05 rad/s.
static void a_pump_goes_back_from_the_soft_limit() {
    SupervisorModel<double> s = test_controller<double>().circuit[0];
    s.hammer = 2e4;
    const double soft = 2.5e5, hard = 3e5, tick = 0.01;
    CHECK(furthest_pump_angle(s, 0.2, 2.4e5, soft, hard, tick) > 100);
    CHECK_NEAR(furthest_pump_angle(s, 0.2, soft, soft, hard, tick), 0.2, 1e-15);
    CHECK_NEAR(furthest_pump_angle(s, 0.2, hard, soft, hard, tick), 0.185, 1e-15);
    CHECK_NEAR(furthest_pump_angle(s, 0.2, 5e5, soft, hard, tick), 0.185, 1e-15);  // no further: a sensor may lie
    s.hammer = 1e6;
    CHECK_NEAR(furthest_pump_angle(s, 0.2, hard, soft, hard, tick), 0.2 - 0.05 * tick, 1e-15);
}

/// 60 kPa of fill, and four powers of a bend of 0.5 rad: 1 + 0.5 + 0.25 + 0.125 times 10 kPa.
static void the_pressure_of_a_bend_by_hand() {
    SupervisorModel<double> s{};
    s.fill = 6e4;
    for (int k = 0; k < hold_terms; ++k) s.hold[k] = 2e4;
    CHECK_NEAR(held(s, 0.5), 6e4 + 1e4 * (1 + 0.5 + 0.25 + 0.125), 1e-9);
    CHECK(held(s, 0.0) == 6e4);
}

/// A beat of a joint that bends by 1 rad and 100 rad/s at most.
static BeatEnd<double> beat_of(double bend, double frequency = 2) { return {bend, frequency, 1, 100}; }

/// A governor that has seen a pressure in a beat of a frequency.
static Governor<double> governor_after(double ceiling, double pressure, double frequency = 2) {
    Governor<double> g{};
    g.ceiling = g.bend_limit = g.sent = ceiling, g.frequency = frequency, g.peak = pressure;
    return g;
}

/// A beat whose pressure is the fill plus x times the margin makes the next beat 1 / x as wide, or wider by the fourth
/// root.
static void the_governor_by_hand() {
    const double fill = 6e4, work = 2e5, room = work - fill;
    const auto after = [&](double load, bool untrusted) {
        Governor<double> g = governor_after(0.2, fill + room * load);
        g.untrusted = untrusted;
        govern(g, beat_of(0.2), fill, work);
        CHECK(g.peak == fill && !g.untrusted);
        return g;
    };
    CHECK_NEAR(after(1.25, false).ceiling, 0.16, 1e-15);
    CHECK_NEAR(after(1.25, true).ceiling, 0.16, 1e-15);  // a doubtful beat may be cut
    CHECK_NEAR(after(3.0, false).ceiling, 0.2 * governor_min, 1e-15);
    CHECK_NEAR(after(1 / 1.4641, false).ceiling, 0.22, 1e-12);  // 1.1^4
    CHECK_NEAR(after(0.01, false).ceiling, 0.2 * governor_max, 1e-15);
    CHECK(after(0.01, true).ceiling == 0.2);  // a doubtful beat does not let it grow
    CHECK(after(0.5, false).proven == 0.2 && after(0.5, true).proven == 0 && after(1.25, false).proven == 0);
}

/// Other causes that cut a beat, or keep it from growing.
static void the_governor_sees_more_than_pressure() {
    const double fill = 6e4, work = 2e5;
    const auto after = [&](const auto& change) {
        Governor<double> g = governor_after(0.2, 1e5);
        BeatEnd<double> beat = beat_of(0.2);
        change(g, beat);
        govern(g, beat, fill, work);
        return g;
    };
    // A ceiling that fell within the beat grows from its lowest value, not from the amplitude that the beat still had.
    CHECK(after([](auto& g, auto&) { g.ceiling = 0.02; }).ceiling < 0.02 * governor_max);
    // A joint that swings by 0.4 rad at 2 Hz bends at up to 5 rad/s: faster than its oil allows, or not.
    const auto swings = [](auto& g, auto&) { g.swung = 0.4; };
    CHECK(after(swings).ceiling > 0.2);
    const Governor<double> cut = after([&](auto& g, auto& b) { swings(g, b), b.rate = 5; });
    CHECK_NEAR(cut.ceiling, 0.2 * governor_swing * 5 / (2 * pi * 2 * 0.4), 1e-15);
    CHECK(after([](auto&, auto& b) { b.reach = 0.1; }).ceiling == 0.1);  // no wider than the pumps reach
}

/// With the pressure above the fill proportional to a power of the amplitude, the beat reaches the working pressure and
/// stays there.
static void the_governor_settles() {
    const double fill = 6e4, work = 2e5;
    for (double power : {1.0, 2.0, 3.0}) {
        Governor<double> g = governor_after(0.05, fill);
        double most = 0, pressure = 0;
        for (int beat = 0; beat < 60; ++beat) {
            pressure = g.peak = fill + 1e6 * std::pow(g.ceiling, power);
            most = std::fmax(most, pressure);
            govern(g, beat_of(g.ceiling), fill, work);
        }
        CHECK_NEAR(pressure, work, 0.02 * work);
        CHECK(most < 1.05 * work);
    }
}

/// A frequency higher than any before begins with the amplitude that the model holds safe; a lower one continues as
/// before.
static void a_new_frequency_begins_safe() {
    Governor<double> g = governor_after(0.3, 0);
    expect(g, 1.0, 0.1);
    CHECK(g.ceiling == 0.3);
    expect(g, 4.0, 0.1);
    CHECK(g.ceiling == 0.1 && g.frequency == 4);
    g.ceiling = 0.25;  // grown since
    expect(g, 4.0, 0.1);
    CHECK(g.ceiling == 0.25);
}

static void every_condition_has_its_text() {
    for (const ConditionText& text : condition_texts) CHECK(text.name && text.sentence && *text.sentence);
    Status status{};
    status.set(Condition::hard_stop, 3);
    CHECK(status.has(Condition::hard_stop) && status.has(Condition::hard_stop, 3) &&
          !status.has(Condition::hard_stop, 2));
    CHECK(!status.has(Condition::blind) && conditions <= 32 && max_servos <= std::numeric_limits<Places>::digits);
}

int main() {
    implausible_readings();
    a_reading_is_stuck_only_where_the_robot_moves();
    a_slow_sensor_is_stuck_as_soon_as_the_robot_moved_as_far();
    a_contradicted_sensor_is_faulty();
    the_pressure_of_a_bend_by_hand();
    a_pump_goes_back_from_the_soft_limit();
    the_governor_by_hand();
    the_governor_sees_more_than_pressure();
    the_governor_settles();
    a_new_frequency_begins_safe();
    every_condition_has_its_text();
    return failures();
}
