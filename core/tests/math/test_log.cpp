/// log1p: known values, the standard library's in long double, its domain, and the same bits in every lane.
#include <algorithm>
#include <limits>

#include "check.hpp"
#include "hypertuna/math/log.hpp"

using namespace hypertuna;

static void known_values() {
    const double infinite = std::numeric_limits<double>::infinity();
    CHECK(same_bits(hypertuna::log1p(0.0), 0.0));
    CHECK_NEAR(hypertuna::log1p(1.0), 0.69314718055994530942, 2e-16);
    CHECK_NEAR(hypertuna::log1p(-0.5), -0.69314718055994530942, 2e-16);
    CHECK(same_bits(hypertuna::log1p(1e-20), 1e-20));
    for (double none : {-1.0, -1.5, -infinite, infinite, std::numeric_limits<double>::quiet_NaN()})
        CHECK(!(std::abs(hypertuna::log1p(none)) < infinite));
}

/// Off by less than 1.25 units in the last place from just above -1 to 1e9, also where 1 + x rounds x away.
static void against_standard() {
    double worst = 0;
    for (int k = 0; k < 200001; ++k) {
        const double along = k / 200000.0, small = std::pow(10.0, -18 * along);
        for (double x : {small, -0.999999 * small, 1e9 * along, -0.9999999 * along, 2 * along - 1 + 1e-9}) {
            const long double wanted = std::log1p((long double)x);
            const double ulp = std::abs(std::nextafter(double(wanted), 1e300) - double(wanted));
            worst = std::max(worst, double(std::abs(hypertuna::log1p(x) - wanted)) / ulp);
        }
    }
    CHECK(0 < worst && worst < 1.25);
}

static void derivative() {
    Dual<double, 1> x(0.3);
    x.d[0] = 2;
    CHECK_NEAR(hypertuna::log1p(x).d[0], 2 / 1.3, 1e-15);
}

template <int W>
static void lanes() {
    for (int k = 0; k < 1000; ++k) {
        Lanes<double, W> x;
        for (int i = 0; i < W; ++i) x.set(i, -1 + std::pow(1.02, k - 500 + 7 * i));
        const Lanes<double, W> got = hypertuna::log1p(x);
        for (int i = 0; i < W; ++i) CHECK(same_bits(got[i], hypertuna::log1p(x[i])));
    }
}

int main() {
    known_values();
    against_standard();
    derivative();
    lanes<2>();
    lanes<4>();
    lanes<8>();
    return failures();
}
