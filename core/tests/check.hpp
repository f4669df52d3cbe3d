/// Checks: each one that fails prints its place and its values and lets the test go on. `main` ends with
/// `return failures();`.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstring>

inline int failed_checks = 0;

inline int failures() { return failed_checks == 0 ? 0 : 1; }

inline void check(bool holds, const char* text, const char* file, int line) {
    if (holds) return;
    ++failed_checks;
    std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, text);
}

/// NaN is near no number.
inline void check_near(double got, double wanted, double tolerance, const char* text, const char* file, int line) {
    if (got == wanted || std::fabs(got - wanted) <= tolerance) return;
    ++failed_checks;
    std::fprintf(stderr, "%s:%d: %s is %.17g, but should be %.17g within %.3g: %.3g off\n", file, line, text, got,
                 wanted, tolerance, std::fabs(got - wanted));
}

#define CHECK(condition) check(condition, #condition, __FILE__, __LINE__)
#define CHECK_NEAR(got, wanted, tolerance) check_near(got, wanted, tolerance, #got, __FILE__, __LINE__)

/// The same number bit for bit: tells 0 from -0, and takes one NaN for itself.
template <class T>
bool same_bits(T a, T b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}
