/// Dual numbers: derivatives by hand, then every operation against central differences, then Dual of Lanes.
#include <limits>

#include "check.hpp"
#include "hypertuna/math/dual.hpp"
#include "hypertuna/math/trig.hpp"

using namespace hypertuna;

template <class S>
static Dual<S, 2> direction(const S& x, int k) {
    Dual<S, 2> dual(x);
    dual.d[k] = S(1);
    return dual;
}

static void by_hand() {
    const Dual<double, 2> x = direction(3.0, 0), y = direction(4.0, 1);
    const Dual<double, 2> product = x * y, quotient = x / y, root = sqrt(x * x + y * y);
    CHECK(product.v == 12 && product.d[0] == 4 && product.d[1] == 3);
    CHECK(quotient.v == 0.75 && quotient.d[0] == 0.25 && quotient.d[1] == -3.0 / 16);
    CHECK(root.v == 5);
    CHECK_NEAR(root.d[0], 0.6, 1e-15);
    CHECK_NEAR(root.d[1], 0.8, 1e-15);
    CHECK((x < y) && (x <= y) && !(y < x));
    const Dual<double, 2> quadratic = times_abs(-x);
    CHECK(quadratic.v == -9 && quadratic.d[0] == -6 && quadratic.d[1] == 0);
    const Dual<double, 2> constant(7.0);
    CHECK(value(x) == 3 && constant.d[0] == 0);
    CHECK(times_abs(direction(0.0, 0)).d[0] == 0);  // v |v| is smooth at rest
}

/// f(x, y) of plain numbers, differentiated by central differences, and of dual numbers.
template <class Function>
static void against_differences(const Function& f) {
    const double h = std::cbrt(std::numeric_limits<double>::epsilon());  // truncation h^2 balances rounding eps / h
    for (double x : {-1.3, -0.2, 0.4, 2.1})
        for (double y : {-0.9, 0.3, 1.7}) {
            const Dual<double, 2> got = f(direction(x, 0), direction(y, 1));
            CHECK_NEAR(got.v, f(x, y), 1e-15 * (1 + std::fabs(got.v)));
            CHECK_NEAR(got.d[0], (f(x + h, y) - f(x - h, y)) / (2 * h), 100 * h * h * (1 + std::fabs(got.d[0])));
            CHECK_NEAR(got.d[1], (f(x, y + h) - f(x, y - h)) / (2 * h), 100 * h * h * (1 + std::fabs(got.d[1])));
        }
}

/// The same function in lanes: every lane as if it were alone.
template <class Function>
static void lanes_equal_scalar(const Function& f) {
    const double x[4] = {-1.3, -0.2, 0.4, 2.1}, y[4] = {1.7, -0.9, 0.3, 0.3};
    Lanes<double, 4> xs(0.0), ys(0.0);
    for (int k = 0; k < 4; ++k) xs.set(k, x[k]), ys.set(k, y[k]);
    const Dual<Lanes<double, 4>, 2> got = f(direction(xs, 0), direction(ys, 1));
    for (int k = 0; k < 4; ++k) {
        const Dual<double, 2> alone = f(direction(x[k], 0), direction(y[k], 1));
        CHECK(same_bits(got.v[k], alone.v));
        CHECK(same_bits(got.d[0][k], alone.d[0]));
        CHECK(same_bits(got.d[1][k], alone.d[1]));
    }
}

template <class Function>
static void function(const Function& f) {
    against_differences(f);
    lanes_equal_scalar(f);
}

/// A number that has no derivatives, of the kind that x is made of.
template <class X>
static auto constant(const X& x, double number) {
    return decltype(value(x))(number);
}

int main() {
    by_hand();
    function([](auto x, auto y) { return x + y; });
    function([](auto x, auto y) { return x - y; });
    function([](auto x, auto y) { return x * y; });
    function([](auto x, auto y) { return x / y; });
    function([](auto x, auto) { return -x; });
    function([](auto x, auto y) { return x += y * y; });
    function([](auto x, auto y) { return x -= y * y; });
    function([](auto x, auto) { return x + constant(x, 0.7); });
    function([](auto x, auto) { return constant(x, 0.7) + x; });
    function([](auto x, auto) { return x - constant(x, 0.7); });
    function([](auto x, auto) { return constant(x, 0.7) - x; });
    function([](auto x, auto) { return x * constant(x, 0.7); });
    function([](auto x, auto) { return constant(x, 0.7) * x; });
    function([](auto x, auto) { return x / constant(x, 0.7); });
    function([](auto x, auto y) { return sqrt(x * x + y * y); });
    function([](auto x, auto) { return abs(x); });
    function([](auto x, auto y) { return times_abs(x * y); });
    function([](auto x, auto y) { return max(x, y); });
    function([](auto x, auto y) { return min(x, y); });
    function([](auto x, auto y) { return select(x < y, x * y, y / x); });
    function([](auto x, auto y) { return sincos(x * y).sin; });
    function([](auto x, auto y) { return sincos(x + y * y).cos; });
    return failures();
}
