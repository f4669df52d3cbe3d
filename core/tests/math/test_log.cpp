/// log_quotient: known values, the standard library's in long double, its domain, and the same bits in every lane.
#include <algorithm>
#include <limits>

#include "check.hpp"
#include "hypertuna/math/log.hpp"

using namespace hypertuna;

template <class S>
static S log_of(const S& n, const S& d) {
    return log_quotient(n, d, n - d);
}

static void known_values() {
    CHECK(same_bits(log_of(0.3, 0.3), 0.0));
    CHECK_NEAR(log_of(2.0, 1.0), 0.69314718055994530942, 2e-16);
    CHECK_NEAR(log_of(1.0, 2.0), -0.69314718055994530942, 2e-16);
    CHECK_NEAR(log_quotient(1 + 1e-20, 1.0, 1e-20), 1e-20, 2e-36);
    const double infinite = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
    for (double n : {0.0, -1.5, -infinite, none}) CHECK(!(std::abs(log_of(n, 1.0)) < infinite));
    CHECK(!(std::abs(log_quotient(1.0, 1.0, none)) < infinite));
}

/// Off by less than 2.5 units in the last place for quotients from 1e-9 to 1e9, and for those that differ from 1 by
/// down to 1e-18.
static void against_standard() {
    double worst = 0;
    for (int k = 0; k < 200001; ++k) {
        const double along = k / 200000.0, small = std::pow(10.0, -18 * along), d = 1 + 3 * along;
        for (double x : {small, -0.999999 * small, 1e9 * along, -0.9999999 * along, 2 * along - 1 + 1e-9}) {
            const double n = d + x;
            const bool near = std::abs(x) < 0.25 * d;  // a quotient near 1 is not sensitive to the rounding of n
            const long double wanted = near ? std::log1p((long double)x / d) : std::log((long double)n / d);
            const double ulp = std::abs(std::nextafter(double(wanted), 1e300) - double(wanted));
            worst = std::max(worst, double(std::abs(log_quotient(n, d, near ? x : n - d) - wanted)) / ulp);
        }
    }
    CHECK(0 < worst && worst < 2.5);
}

static void derivatives() {
    Dual<double, 2> n(1.3), d(0.7);
    n.d[0] = 2, d.d[1] = 3;
    CHECK_NEAR(log_of(n, d).d[0], 2 / 1.3, 1e-15);
    CHECK_NEAR(log_of(n, d).d[1], -3 / 0.7, 1e-15);
}

template <int W>
static void lanes() {
    for (int k = 0; k < 1000; ++k) {
        Lanes<double, W> n;
        for (int i = 0; i < W; ++i) n.set(i, std::pow(1.02, k - 500 + 7 * i));
        const Lanes<double, W> d = n * n + Lanes<double, W>(0.3), got = log_of(n, d);
        for (int i = 0; i < W; ++i) CHECK(same_bits(got[i], log_of(n[i], d[i])));
    }
}

int main() {
    known_values();
    against_standard();
    derivatives();
    lanes<2>();
    lanes<4>();
    lanes<8>();
    return failures();
}
