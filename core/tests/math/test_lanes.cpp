/// Lanes: every operation does in each lane what the plain number does.
#include <limits>

#include "check.hpp"
#include "hypertuna/math/lanes.hpp"

using namespace hypertuna;

template <class T>
constexpr T numbers[] = {T(0),
                         T(-0.0),
                         T(1),
                         T(-2.5),
                         T(3),
                         T(1e-30),
                         T(-7e20),
                         std::numeric_limits<T>::infinity(),
                         std::numeric_limits<T>::quiet_NaN()};

/// Some operation of two numbers, in lanes and alone: same bits, except that any NaN is as good as another.
template <class T, int W, class Operation>
static void lanes_equal_scalar(const Operation& operation) {
    for (T first : numbers<T>)
        for (T second : numbers<T>) {
            Lanes<T, W> a(T(4)), b(T(-9));
            for (int k = 0; k < W; k += 2) a.set(k, first), b.set(k, second);  // neighbors must not mix
            const Lanes<T, W> got = operation(a, b);
            for (int k = 0; k < W; ++k) {
                const T alone = operation(a[k], b[k]);
                CHECK(same_bits(got[k], alone) || (std::isnan(got[k]) && std::isnan(alone)));
            }
        }
}

template <class T, int W>
static void operations() {
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a + b; });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a - b; });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a * b; });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a / b; });
    lanes_equal_scalar<T, W>([](auto a, auto) { return -a; });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a += b; });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return a -= b; });
    lanes_equal_scalar<T, W>([](auto a, auto) { return abs(a); });
    lanes_equal_scalar<T, W>([](auto a, auto) { return sqrt(abs(a)); });
    lanes_equal_scalar<T, W>([](auto a, auto) { return times_abs(a); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return max(a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return min(a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return select(a < b, a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return select(a <= b, a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return select(!(a < b), a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return select((a < b) & (b < a + a), a, b); });
    lanes_equal_scalar<T, W>([](auto a, auto b) { return select((a < b) | (b < a + a), a, b); });
}

/// One lane at a time holds the exception.
template <class T, int W>
static void any_and_all() {
    const Lanes<T, W> zero(T(0)), one(T(1));
    CHECK(!any(one < zero) && !all(one < zero));
    CHECK(any(zero < one) && all(zero < one));
    for (int k = 0; k < W; ++k) {
        Lanes<T, W> x = one;
        x.set(k, T(-1));
        CHECK(any(x < zero) && !all(x < zero));
        CHECK(any(zero < x) && !all(zero < x));
        x.set(k, std::numeric_limits<T>::quiet_NaN());
        CHECK(!any(x < zero) && !all(zero < x) && any(!(zero < x)));
    }
}

int main() {
    operations<double, 2>(), any_and_all<double, 2>();
    operations<double, 4>(), any_and_all<double, 4>();
    operations<double, 8>(), any_and_all<double, 8>();
    operations<float, 4>(), any_and_all<float, 4>();
    operations<float, 8>(), any_and_all<float, 8>();
    CHECK(select(true, 1.0, 2.0) == 1.0 && select(false, 1.0, 2.0) == 2.0);
    CHECK(times_abs(-3.0) == -9.0 && times_abs(3.0) == 9.0);
    return failures();
}
