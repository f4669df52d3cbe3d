/// Sine and cosine: known values, the standard library's, symmetries, and the same bits in every lane.
#include <algorithm>
#include <limits>

#include "check.hpp"
#include "hypertuna/math/trig.hpp"

using namespace hypertuna;

template <class T>
constexpr T epsilon = std::numeric_limits<T>::epsilon();  // two units in the last place of 1 - ulp

static void known_values() {
    const double half = std::sqrt(0.5);
    const double sines[8] = {0, half, 1, half, 0, -half, -1, -half};
    for (int k = -16; k < 16; ++k) {  // every 45 degrees over four turns
        const SinCos<double> at = sincos(k * pi / 4);
        const double rounding = epsilon<double> * (1 + std::abs(k));  // of k pi / 4 itself
        CHECK_NEAR(at.sin, sines[(k + 16) % 8], rounding);
        CHECK_NEAR(at.cos, sines[(k + 18) % 8], rounding);
    }
    CHECK(same_bits(sincos(0.0).sin, 0.0));
    CHECK(same_bits(sincos(0.0).cos, 1.0));
    const SinCos<double> none = sincos(std::numeric_limits<double>::quiet_NaN());
    CHECK(std::isnan(none.sin) && std::isnan(none.cos));
}

/// Against the standard library in long double, on a grid that hits no special points.
template <class T>
static void against_standard(T range, T tolerance) {
    const int count = 20001;
    T worst = 0;
    for (int k = 0; k < count; ++k) {
        const T x = range * (T(2) * T(k) / T(count - 1) - T(1)) * T(0.99999);
        const SinCos<T> at = sincos(x);
        worst = std::max(worst, std::fabs(T(at.sin - std::sin((long double)x))));
        worst = std::max(worst, std::fabs(T(at.cos - std::cos((long double)x))));
    }
    CHECK_NEAR(worst, 0, tolerance);
}

/// Near the zeros what counts is the relative error, which the reduction by parts of pi/2 keeps small.
static void near_zeros() {
    for (int k = 0; k <= 1000; ++k)
        for (double offset : {1e-3, 1e-6, -1e-6}) {
            const double x = k * pi / 2 + offset;
            const long double wanted = k % 2 ? std::cos((long double)x) : std::sin((long double)x);
            const double got = k % 2 ? sincos(x).cos : sincos(x).sin;
            CHECK_NEAR(double(got / wanted), 1, 2 * epsilon<double>);
        }
}

static void symmetries() {
    for (double x = 0.01; x < 50; x += 0.37) {
        const SinCos<double> at = sincos(x), mirrored = sincos(-x);
        CHECK(same_bits(mirrored.sin, -at.sin));
        CHECK(same_bits(mirrored.cos, at.cos));
        CHECK_NEAR(at.sin * at.sin + at.cos * at.cos, 1, 2 * epsilon<double>);
    }
}

template <class T, int W>
static void lanes_equal_scalar() {
    for (T start : {T(-700), T(-3), T(0), T(0.1), T(60)}) {
        Lanes<T, W> x(start);
        for (int k = 0; k < W; ++k) x.set(k, start + T(k) * T(0.9));
        const SinCos<Lanes<T, W>> at = sincos(x);
        for (int k = 0; k < W; ++k) {
            CHECK(same_bits(at.sin[k], sincos(x[k]).sin));
            CHECK(same_bits(at.cos[k], sincos(x[k]).cos));
        }
    }
}

int main() {
    known_values();
    against_standard<double>(0.78, epsilon<double>);  // one octant: polynomials alone
    against_standard<double>(100, epsilon<double>);
    against_standard<double>(1e5, epsilon<double>);
    against_standard<float>(0.78f, epsilon<float>);
    against_standard<float>(100, epsilon<float>);
    against_standard<float>(1000, epsilon<float>);
    near_zeros();
    symmetries();
    lanes_equal_scalar<double, 2>();
    lanes_equal_scalar<double, 4>();
    lanes_equal_scalar<double, 8>();
    lanes_equal_scalar<float, 4>();
    lanes_equal_scalar<float, 8>();
    return failures();
}
