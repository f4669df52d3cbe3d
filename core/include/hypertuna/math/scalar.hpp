/// Plain numbers: the handful of operations that every scalar of the core offers.
///
/// The core is written once over a scalar S. S is `double` or `float` (one gait), `Lanes` (several gaits
/// side by side, lanes.hpp) or `Dual` (a value with exact derivatives, dual.hpp). Comparisons give a
/// mask (`bool` here), and `select` takes the place of branches.
#pragma once

#include <cmath>
#include <concepts>
#include <utility>

// Each instruction set compiles the whole core inside a namespace of its own: otherwise the linker
// would merge equal template names and a machine could run code made for another.
#ifndef HYPERTUNA_ARCH
#define HYPERTUNA_ARCH portable
#endif

#ifdef __SANITIZE_ADDRESS__
#define HYPERTUNA_INLINE inline  // without forced inlining it compiles in two thirds of the time
#else
#define HYPERTUNA_INLINE inline __attribute__((always_inline))
#endif
#define HYPERTUNA_NOINLINE __attribute__((noinline))
#ifdef __clang__
#define HYPERTUNA_UNROLL _Pragma("unroll")
#else
#define HYPERTUNA_UNROLL _Pragma("GCC unroll 8")
#endif

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double gravity = 9.81;  // m/s^2

/// The plain number that a scalar is made of, e.g. base_t<Dual<Lanes<float, 4>, 3>> is float.
template <class S>
struct Base {
    using type = S;
};
template <class S>
using base_t = typename Base<S>::type;

/// Make a struct whose members are all of type S from a row of numbers in the order of the members; `columns` are the
/// members' names.
template <class Struct, class S, std::size_t columns, class T>
Struct read_row(const char* const (&)[columns], const T* row) {
    static_assert(sizeof(Struct) == columns * sizeof(S));
    return [row]<std::size_t... k>(std::index_sequence<k...>) {
        return Struct{S(row[k])...};
    }(std::make_index_sequence<columns>{});
}

/// Type of the product of two scalars, e.g. a Dual where one of them is a Dual and the other is its value's type.
template <class A, class B>
using product_t = decltype(std::declval<A>() * std::declval<B>());

template <std::floating_point S>
HYPERTUNA_INLINE S select(bool mask, S yes, S no) {
    return mask ? yes : no;
}
HYPERTUNA_INLINE bool any(bool mask) { return mask; }
HYPERTUNA_INLINE bool all(bool mask) { return mask; }

template <std::floating_point S>
HYPERTUNA_INLINE S abs(S x) {
    return std::fabs(x);
}
template <std::floating_point S>
HYPERTUNA_INLINE S sqrt(S x) {
    return std::sqrt(x);
}

/// x |x|, the quadratic drag law.
template <std::floating_point S>
HYPERTUNA_INLINE S times_abs(S x) {
    return x * std::fabs(x);
}

/// A value without its derivatives.
template <std::floating_point S>
HYPERTUNA_INLINE S value(S x) {
    return x;
}

/// A scalar without derivatives, e.g. value_t<Dual<Lanes<double, 4>, 3>> is Lanes<double, 4>.
template <class S>
using value_t = decltype(value(std::declval<S>()));

template <class S>
HYPERTUNA_INLINE S max(const S& a, const S& b) {
    return select(a < b, b, a);
}
template <class S>
HYPERTUNA_INLINE S min(const S& a, const S& b) {
    return select(b < a, b, a);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
