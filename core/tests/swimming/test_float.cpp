/// Single precision, as a microcontroller has it: against double, and eight gaits in the lanes.
#include <limits>

#include "check.hpp"
#include "fish.hpp"

using namespace hypertuna;
using Eight = Lanes<float, 8>;

static constexpr int beats = 400;  // from rest: the slowest gait to settle here is 30 % short of its speed after 100

template <class Fish>
static auto swum(const Fish& fish) {
    return wait(fish.body(), fish.rest(), beats).beat;
}

static double gait_frequency(int k) { return 0.5 + 0.5 * k; }
static double gait_amplitude(int k) { return 0.25 - 0.02 * k; }

/// Speed and power of single precision are good to 1e-4; Newton's method comes to the same beat.
template <template <class> class Law>
static void against_double() {
    for (int k = 0; k < 8; ++k) {
        const Fish<double, Law<double>> exact(gait_frequency(k), gait_amplitude(k));
        const Fish<float, Law<float>> single(float(gait_frequency(k)), float(gait_amplitude(k)));
        const Beat<double> wanted = swum(exact);
        const Beat<float> got = swum(single);
        CHECK_NEAR(got.displacement.x / wanted.displacement.x, 1, 1e-4);
        CHECK_NEAR(got.power / wanted.power, 1, 1e-4);

        Search<float> search = search_from(single.brisk(), 0.0f);
        newton(single.body(), 1, 1e-3f, false, 60, search);
        CHECK(search.distance < 1e-3f);
        const Beat<float> solved = single.body().measure(search.P);
        CHECK_NEAR(solved.displacement.x / wanted.displacement.x, 1, 1e-4);
    }
}

template <template <class> class Law>
static void lanes_equal_scalar() {
    Eight frequency(0.0f), amplitude(0.0f);
    for (int k = 0; k < 8; ++k) {
        frequency.set(k, float(gait_frequency(k)));
        amplitude.set(k, float(gait_amplitude(k)));
    }
    const Beat<Eight> together = swum(Fish<Eight, Law<Eight>>(frequency, amplitude));
    for (int k = 0; k < 8; ++k) {
        const Beat<float> alone = swum(Fish<float, Law<float>>(frequency[k], amplitude[k]));
        CHECK(same_bits(together.displacement.x[k], alone.displacement.x));
        CHECK(same_bits(together.power[k], alone.power));
        CHECK(same_bits(together.excursion[k], alone.excursion));
    }
}

int main() {
#define CHECK_LAW(Law) against_double<Law>(), lanes_equal_scalar<Law>();
    HYPERTUNA_WATER_LAWS(CHECK_LAW)
    return failures();
}
