/// Steering and the mission's bounds, by hand.
#include "cruise.hpp"

using namespace hypertuna;

static void gaits_between_gaits() {
    const Steering<double> model = test_steering<double>();
    const Beating<double> on = beating(model.table, 2, 0.3);
    CHECK_NEAR(on.frequency, 2, 1e-12);
    const Beating<double> between = beating(model.table, 2, 0.35);
    CHECK_NEAR(between.frequency, 2 + 1.0 / 3, 1e-12);
    CHECK_NEAR(between.amplitude[1], 0.4, 1e-12);
    const Beating<double> slow = beating(model.table, 2, 0.05);
    CHECK_NEAR(slow.frequency, 1.0 / 3, 1e-12);
    CHECK_NEAR(beating(model.table, 2, 9.0).frequency, 3, 1e-12);
    CHECK_NEAR(beating(model.table, 2, -1.0).frequency, 0, 1e-12);
    double last = -1;
    for (double speed = 0; speed < 0.5; speed += 0.01) {
        const Beating<double> now = beating(model.table, 2, speed);
        CHECK(last <= now.frequency);
        last = now.frequency;
    }
}

/// Swimming at the crab angle makes good a course along the leg, at the predicted speed.
static void crab_by_hand() {
    const double current[2] = {0.1, -0.05};
    for (double angle = 0; angle < 6.3; angle += 0.3) {
        const Course<double> course{std::cos(angle), std::sin(angle)};
        const Course<double> heading = crab(course, current, 0.3);
        const double x = 0.3 * heading.x + current[0], y = 0.3 * heading.y + current[1];
        CHECK_NEAR(course.x * y - course.y * x, 0, 1e-12);
        CHECK_NEAR(course.x * x + course.y * y, made_good(course, current, 0.3), 1e-12);
    }
    const double strong[2] = {0, 1};  // the robot cannot win, but heads against the current
    CHECK(crab({1, 0}, strong, 0.3).y < -0.85);
}

static void line_of_sight_by_hand() {
    const Leg<double> leg = line_of_sight<double>({0, 0}, {10, 0}, 3, 4, 4, {0, 1});
    CHECK_NEAR(leg.along, 3, 1e-12);
    CHECK_NEAR(leg.across, 4, 1e-12);
    CHECK_NEAR(leg.course.x, std::sqrt(0.5), 1e-12);
    CHECK_NEAR(leg.course.y, -std::sqrt(0.5), 1e-12);
    // Past the end of a leg the robot steers back to the end; a leg of no length leads to its end.
    CHECK_NEAR((line_of_sight<double>({0, 0}, {10, 0}, 14, 0, 4, {0, 1}).course.x), -1, 1e-12);
    CHECK_NEAR((line_of_sight<double>({5, 5}, {5, 5}, 5, 2, 4, {1, 0}).course.y), 1, 1e-12);
    CHECK_NEAR((line_of_sight<double>({5, 5}, {5, 5}, 5, 5, 4, {1, 0}).course.x), 1, 1e-12);
}

static void fences_by_hand() {
    Mission<double> m{};
    CHECK(inside(m, 1e4, 0.0).distance > 1e5);
    m.center = {1, 2}, m.range = 10;
    CHECK_NEAR(inside(m, 1.0, 9.0).distance, 3, 1e-12);
    CHECK_NEAR(inside(m, 1.0, 9.0).y, -1, 1e-12);
    CHECK_NEAR(inside(m, 16.0, 2.0).distance, -5, 1e-12);
    // An L, either way round: 2 by 2 without its upper right quarter.
    const Corner<double> left[] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    Corner<double> right[6];
    for (int k = 0; k < 6; ++k) right[k] = left[5 - k];
    m.corners = 6;
    for (const Corner<double>* fence : {left, static_cast<const Corner<double>*>(right)}) {
        m.corner = fence;
        CHECK_NEAR(inside(m, 0.5, 0.5).distance, 0.5, 1e-12);
        CHECK_NEAR(inside(m, 1.8, 0.5).distance, 0.2, 1e-12);
        CHECK_NEAR(inside(m, 1.8, 0.5).x, -1, 1e-12);
        CHECK_NEAR(inside(m, 1.5, 1.2).distance, -0.2, 1e-12);
        CHECK_NEAR(inside(m, 1.5, 1.2).y, -1, 1e-12);
        CHECK_NEAR(inside(m, 1.3, 1.4).distance, -0.3, 1e-12);
        CHECK_NEAR(inside(m, -3.0, 6.0).distance, -5, 1e-12);
        CHECK(is_finite(inside(m, 0.0, 0.0).x));  // on a corner
    }
    // Compared with the fraction of random places that lie inside.
    int within = 0;
    for (int k = 0; k < 20000; ++k) {
        const double x = 2 * uniform<double>(random_bits(1, 0, std::uint64_t(k))),
                     y = 2 * uniform<double>(random_bits(1, 1, std::uint64_t(k)));
        const bool in = inside(m, x, y).distance > 0;
        CHECK(in == (x < 1 || y < 1));
        within += in;
    }
    CHECK_NEAR(within / 20000.0, 0.75, 0.02);
}

/// The tail bends to the side that turns the head the short way, in proportion to the required rate.
static void bias_by_hand() {
    const Steering<double> model = test_steering<double>();
    SteeringState<double> state{};
    state.beat.mean.x = 1;  // the robot faces east
    // 0.1 rad to port: 0.04 rad/s, half as much again for the rate that is missing; the tail bends to port, which is
    // negative.
    const double small = bias_for(model, state, {std::cos(0.1), std::sin(0.1)}, 0.3);
    CHECK_NEAR(small, -1.5 * 0.4 * 0.1 / (1.2 * 0.3), 1e-3);
    CHECK(state.turn_sum > 0);
    SteeringState<double> fresh{};
    fresh.beat.mean.x = 1;
    CHECK(bias_for(model, fresh, {-1.0, 0.01}, 0.3) == -1);
    CHECK(bias_for(model, fresh, {-1.0, -0.01}, 0.3) == 1);
    CHECK(fresh.turn_sum == 0);   // no integral windup at the limit
    fresh.beat.mean.turn = 0.04;  // the turn rate is as asked, with no error
    CHECK_NEAR(bias_for(model, fresh, {std::cos(0.1), std::sin(0.1)}, 0.3), -0.04 / 0.36, 1e-3);
    // The amplitude shrinks to leave range for the bias.
    Command<double> command{};
    beat_into(model, command, 0.3, -1.0);
    CHECK_NEAR(command.bias[0], -0.14, 1e-12);
    CHECK_NEAR(command.amplitude[0], 0.38 - 0.14, 1e-12);
}

static void depth_by_hand() {
    const Steering<double> model = test_steering<double>();
    SteeringState<double> state{};
    Estimate<double> at{};
    at.speed = 0.3, at.depth = 1;
    CHECK_NEAR(climb_for(model, state, at, 4.0), -0.2, 1e-12);  // far above: the climb is at its limit, without windup
    CHECK(state.climb_sum == 0);
    CHECK_NEAR(climb_for(model, state, at, 0.9), 0.1 / std::sqrt(0.01 + 2.25), 1e-12);
    CHECK(state.climb_sum > 0);
    CHECK_NEAR(fins_for(model, at, 0.1), 0.1 * (3 + 1), 1e-12);  // leading edge up
    at.sink = -0.03;  // it already climbs at that rate: only the lead remains
    CHECK_NEAR(fins_for(model, at, 0.1), 0.1 * 3, 1e-12);
    at.rate.y = 0.05;  // and the nose comes up
    CHECK_NEAR(fins_for(model, at, 0.1), 0.1 * 3 - 0.7 * 0.05, 1e-12);
    at.sink = 1;
    CHECK_NEAR(fins_for(model, at, 0.2), 0.7, 1e-12);
    at.facing.z = -0.5;  // at the limit of pitch no more is commanded
    CHECK(climb_for(model, state, at, 0.0) == 0 && climb_for(model, state, at, 4.0) == 0);
    at.facing.z = 0.375;
    CHECK_NEAR(climb_for(model, state, at, 4.0), -0.1, 1e-12);
}

/// Over whole beats the head's swing cancels, at any frequency.
static void means_over_a_beat() {
    for (double frequency : {1.0, 2.0, 3.3, 6.0}) {
        BeatMean<double> beat{};
        double worst = 0, phase = 0;
        for (int k = 0; k < 600; ++k) {
            const double before = phase;
            phase += frequency * 0.01;
            Estimate<double> at{};
            const double yaw = 0.5 + 0.15 * std::sin(2 * pi * phase);
            at.facing = {std::cos(yaw), std::sin(yaw), 0};
            at.rate.z = 0.15 * 2 * pi * frequency * std::cos(2 * pi * phase);
            update(beat, at, std::floor(before) != std::floor(phase), 100);
            if (k > 200) worst = std::fmax(worst, std::fabs(std::atan2(beat.mean.y, beat.mean.x) - 0.5));
        }
        CHECK(worst < 0.02);
    }
}

/// A commanded beat is steered by the same command as a long straight leg.
static void steered_as_on_a_leg() {
    const Pilot<double> pilot = test_pilot<double>();
    const Waypoint<double> far[] = {{0, 1e100, 2, 0.3, 2, 0}};
    const Mission<double> mission = mission_of(far, 1);
    Estimate<double> at{};
    at.attitude = at.compass = at.depths = true;
    at.depth = 1.4, at.sink = 0.02, at.speed = 0.28, at.factor = 1, at.facing = {0.6, 0.79, 0.1};
    PilotState<double> on = init(pilot, mission);
    on.controller.supply = 15.5, on.guidance.rising = false;
    on.guidance.steering.beat.mean.x = 0.6, on.guidance.steering.beat.mean.y = 0.8;
    PilotState<double> by = on;
    Command<double> beat{};
    beat_into(pilot.guidance.steering, beat, 0.3, 0.0);
    beat.fresh = beat.armed = true;
    beat.fin[0] = beat.bias[0] = 0.1;  // the pilot overwrites them
    for (int k = 0; k < 20; ++k) {
        decide(pilot, on, at, mission);
        steer(pilot, by, at, beat, {0.0, 1.0}, 2.0);
        CHECK(on.guidance.mode == Mode::transit && on.command.armed && by.command.armed && by.command.fresh);
        CHECK(on.command.frequency == by.command.frequency && by.command.frequency == beat.frequency);
        for (int j = 0; j < 2; ++j) {
            CHECK(on.command.amplitude[j] == by.command.amplitude[j] && on.command.phase[j] == by.command.phase[j]);
            CHECK(on.command.bias[j] == by.command.bias[j] && on.command.fin[j] == by.command.fin[j]);
        }
    }
    CHECK(by.command.bias[0] < 0 && by.command.amplitude[0] < beat.amplitude[0] && by.command.fin[0] < -0.1);
    at.attitude = false;  // without attitude nothing steers, and the fins lift
    steer(pilot, by, at, beat, {0.0, 1.0}, 2.0);
    CHECK(by.command.bias[0] == 0 && by.command.fin[0] == pilot.guidance.blind_fin);
}

int main() {
    gaits_between_gaits();
    crab_by_hand();
    line_of_sight_by_hand();
    fences_by_hand();
    bias_by_hand();
    depth_by_hand();
    means_over_a_beat();
    steered_as_on_a_leg();
    return failures();
}
