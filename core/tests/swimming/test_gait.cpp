/// Gaits: the first-order lag by hand, and the motion of the joints as derivatives of their angle.
#include <limits>
#include <tuple>

#include "check.hpp"
#include "hypertuna/swimming/gait.hpp"

using namespace hypertuna;

/// At its bandwidth a first-order lag leaves 1 / sqrt(2) of the amplitude, 45 degrees late.
static void lag_by_hand() {
    const double infinite = std::numeric_limits<double>::infinity();
    const Swing<double> ideal = response(Harmonic<double>{0.3, 0.0, 0.1, infinite}, 2.0);
    CHECK(ideal.bias == 0.1 && ideal.sine == 0.3 && ideal.cosine == 0.0);

    const Swing<double> slow = response(Harmonic<double>{0.3, 0.0, 0.1, 2.0}, 2.0);
    CHECK(slow.bias == 0.1);
    CHECK_NEAR(std::hypot(slow.sine, slow.cosine), 0.3 / std::sqrt(2), 1e-16);
    CHECK_NEAR(std::atan2(-slow.cosine, slow.sine), pi / 4, 1e-15);

    const Swing<double> late = response(Harmonic<double>{0.3, pi / 2, 0.0, infinite}, 2.0);  // -0.3 cos(p)
    CHECK_NEAR(late.sine, 0, 1e-16);
    CHECK_NEAR(late.cosine, -0.3, 1e-16);

    // The phase offset adds to the phase of the first-order lag.
    const Swing<double> offset = response(Harmonic<double>{0.3, pi / 2, 0.0, 2.0, pi / 4}, 2.0);
    CHECK_NEAR(std::hypot(offset.sine, offset.cosine), 0.3 / std::sqrt(2), 1e-16);
    CHECK_NEAR(std::atan2(-offset.cosine, offset.sine), pi, 1e-15);
}

/// The group that makes the larger amplitude is the faster one: here the one with the smaller command.
static void largest_rate_by_hand() {
    const double infinite = std::numeric_limits<double>::infinity();
    const Harmonic<double> groups[2] = {{0.4, 0.0, 0.1, 1.0}, {0.3, 0.0, 0.0, infinite}};
    CHECK_NEAR(largest_rate(1, groups, 1.0), 2 * pi * 0.4 / std::sqrt(2), 1e-15);
    CHECK_NEAR(largest_rate(2, groups, 1.0), 2 * pi * 0.3, 1e-15);
    CHECK(largest_rate(0, groups, 1.0) == 0);
}

static void joint_motions() {
    const double frequency = 1.7, h = 1e-4;
    const JointShare<double> joints[3] = {{-1, 0.0}, {0, 0.25}, {0, 0.75}};
    const Swing<double> swing = response(Harmonic<double>{0.4, 0.6, 0.2, 3.0}, frequency);
    const auto motion = [&](double time, int i) {
        JointMotion<double> out[3];
        joint_motion(3, joints, &swing, frequency, sincos(2 * pi * frequency * time), out);
        return out[i];
    };
    for (double time = 0; time < 1; time += 0.09) {
        CHECK(motion(time, 0).angle == 0 && motion(time, 0).rate == 0 && motion(time, 0).acceleration == 0);
        for (int i : {1, 2}) {
            const auto [before, now, after] = std::tuple(motion(time - h, i), motion(time, i), motion(time + h, i));
            // Central differences: h^2 / 6 of the derivative two higher, omega^2 = 114 times as large as this one.
            CHECK_NEAR((after.angle - before.angle) / (2 * h), now.rate, 1e-6);
            CHECK_NEAR((after.rate - before.rate) / (2 * h), now.acceleration, 1e-5);
        }
        CHECK_NEAR(motion(time, 2).angle, 3 * motion(time, 1).angle, 1e-15);  // in the ratio of the links' shares
        CHECK_NEAR(motion(time + 1 / frequency, 1).angle, motion(time, 1).angle, 1e-14);
    }
}

int main() {
    lag_by_hand();
    largest_rate_by_hand();
    joint_motions();
    return failures();
}
