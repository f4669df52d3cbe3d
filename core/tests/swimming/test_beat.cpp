/// Tests of the numbers that are measured on a beat: peaks between samples, offsets from a circle, path and radius; and
/// that a beat which diverged has none.
#include <limits>

#include "check.hpp"
#include "hypertuna/swimming/beat.hpp"

using namespace hypertuna;

/// The parabola through the highest samples of a sine finds its amplitude with an error that falls 16 times as the
/// samples double; the highest sample alone is off by 2 % here.
static void peaks() {
    const auto error = [](int count) {
        const double worst_phase = 0.25;  // worst phase of the peak between samples, fraction of a sample
        return std::fabs(peak<double>(count, [&](int k) { return std::sin(2 * pi * (k + worst_phase) / count); }) - 1);
    };
    CHECK(error(16) < 1e-3);
    CHECK_NEAR(error(16) / error(32), 16, 3);
    CHECK_NEAR(error(32) / error(64), 16, 1);
    const double flat[4] = {2, 2, 2, 2}, spike[4] = {0, 1, 0, 0};
    CHECK(peak<double>(4, [&](int k) { return flat[k]; }) == 2);
    CHECK(peak<double>(4, [&](int k) { return spike[k]; }) == 1);
}

/// A circle of radius 2 through the origin, with its center to the left: at (0, 2).
static void offsets() {
    const SinCos<double> along_x{0, 1};
    CHECK_NEAR(offset(Planar<double>{0, 2, 0}, along_x, 0.5), 2, 1e-15);    // the center is a radius away
    CHECK_NEAR(offset(Planar<double>{2, 2, 0}, along_x, 0.5), 0, 1e-15);    // a point on the circle
    CHECK_NEAR(offset(Planar<double>{0, -1, 0}, along_x, 0.5), -1, 1e-15);  // a point outside, to the right
    CHECK_NEAR(offset(Planar<double>{0, -1, 0}, along_x, -0.5), -1,
               1e-15);                                                    // the same point, for a circle to the right
    CHECK_NEAR(offset(Planar<double>{7, 3, 0}, along_x, 0.0), 3, 1e-15);  // a straight line
    CHECK_NEAR(offset(Planar<double>{0, 3, 0}, SinCos<double>{1, 0}, 0.0), 0, 1e-15);
}

/// A nose that goes around a circle of radius R, at a mean distance `sway` from it, and a tail that sways to both sides
/// of the circle.
static void path_on_circle(double R, double turn, double sway) {
    const int steps = 64;
    BeatSample<double> sample[steps];
    const auto on_circle = [&](double angle, double out) {
        return Planar<double>{(R + out) * std::sin(angle), R - (R + out) * std::cos(angle), 0};
    };
    for (int k = 0; k < steps; ++k) {
        const double swing = std::sin(2 * pi * k / steps);
        sample[k].nose = on_circle(turn * k / steps, sway * (1 - std::cos(2 * pi * k / steps)));
        sample[k].tail = on_circle(turn * k / steps, 4 * sway * swing);
    }
    Beat<double> beat{};
    const Planar<double> end = on_circle(turn, 0);
    beat.displacement = {end.x, end.y, turn};
    measure_path(steps, sample, beat);
    CHECK_NEAR(beat.radius, std::fabs(R + sway), 1e-9);
    CHECK_NEAR(beat.arc, beat.radius * std::fabs(turn), 1e-9);
    CHECK_NEAR(beat.excursion, 8 * sway, 1e-4 * sway);
}

/// A body that turns by `turn` a beat on the spot and drifts by 1 mm a beat. Up to half a turn the mean path is the
/// circle through the nose's places a beat apart; beyond, its center moves to infinity, and so does R turn / T.
static void spinning(double turn, bool path) {
    const int steps = 64;
    BeatSample<double> sample[steps];
    for (int k = 0; k < steps; ++k) {
        const double angle = turn * k / steps;
        sample[k].nose = {0.001 * k / steps + 0.1 * (1 - std::cos(angle)), -0.1 * std::sin(angle), 0};
        sample[k].tail = {sample[k].nose.x + 0.4 * std::cos(angle), sample[k].nose.y + 0.4 * std::sin(angle), 0};
    }
    Beat<double> beat{};
    beat.displacement = {0.001 + 0.1 * (1 - std::cos(turn)), -0.1 * std::sin(turn), turn};
    measure_path(steps, sample, beat);
    CHECK(std::isfinite(mean_speed(beat, 1.0)) == path);
    CHECK(std::isfinite(beat.arc) == path && std::isfinite(beat.radius) == path);
    CHECK(std::isfinite(beat.excursion) == path);
    if (path) CHECK(beat.arc < 0.1 * std::fabs(turn) + 0.003);  // about as far as the nose has gone
}

static void straight_path() {
    const int steps = 64;
    BeatSample<double> sample[steps];
    for (int k = 0; k < steps; ++k) {
        sample[k].nose = {-1.0 * k / steps, 0, 0};
        sample[k].tail = {1 - 1.0 * k / steps, 0.3 * std::cos(2 * pi * k / steps), 0};
    }
    Beat<double> beat{};
    beat.displacement = {-1, 0, 0};
    measure_path(steps, sample, beat);
    CHECK(beat.radius == std::numeric_limits<double>::infinity());
    CHECK_NEAR(beat.arc, 1, 1e-12);
    CHECK_NEAR(beat.excursion, 0.6, 1e-12);
}

/// Torques of 3 N m in the first steps, before the motion grew beyond all numbers, are no peak of the beat.
static void diverged() {
    const double nan = std::numeric_limits<double>::quiet_NaN(), load[4] = {1, 3, nan, nan};
    BeatSample<double> sample[4] = {};
    for (int k = 0; k < 4; ++k) sample[k].load = load[k];
    Beat<double> beat{};
    beat.power = 8;
    measure_end(4, Pose<double>{-1, 0, 0}, sample, beat);
    CHECK(beat.power == 2 && beat.torque_peak == 3);
    beat.power = nan;
    measure_end(4, Pose<double>{-1, 0, 0}, sample, beat);
    CHECK(std::isnan(beat.torque_peak));
}

int main() {
    peaks();
    diverged();
    offsets();
    path_on_circle(2, 0.5, 0.01);
    path_on_circle(2, -0.5, 0.01);  // backward on the same circle
    path_on_circle(-3, -0.1, 0.05);
    for (double turn : {0.5, 3.1, -3.1}) spinning(turn, true);
    for (double turn : {3.2, -3.2, 6.2, 2 * pi, 2 * pi + 0.3, -6.28}) spinning(turn, false);
    straight_path();
    return failures();
}
