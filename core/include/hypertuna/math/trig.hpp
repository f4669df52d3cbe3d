/// Sine and cosine from + - * alone: without contraction to fused multiply-adds (-ffp-contract=off), every machine and
/// every lane gets the same bits.
///
/// The argument is reduced to [-pi/4, pi/4] by multiples of pi/2 (three-part Cody-Waite, good for
/// |x| < 1e5), then two polynomials are taken that are minimax there: relative error 3e-18 before rounding.
#pragma once

#include <bit>
#include <cstdint>
#include <initializer_list>

#include "hypertuna/math/dual.hpp"
#include "hypertuna/math/lanes.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct SinCos {
    S sin, cos;
};

/// pi/2 in three parts, the first two short enough that a multiple of them is exact; and `round`, whose addition rounds
/// to the nearest integer and leaves that integer in the lowest bits.
template <class T>
struct Reduction;
template <>
struct Reduction<double> {
    static constexpr double high = 1.5707963267341256, middle = 6.077100506303966e-11, low = 2.0222662487959506e-21;
    static constexpr double round = 6755399441055744.0;  // 1.5 * 2^52
};
template <>
struct Reduction<float> {
    static constexpr float high = 1.5703125f, middle = 4.837512969970703e-4f, low = 7.549789415861596e-8f;
    static constexpr float round = 12582912.0f;  // 1.5 * 2^23
};

/// Bit `bit` of the integer that rounding left in x, as a mask.
template <std::floating_point T>
HYPERTUNA_INLINE bool rounded_bit(T x, int bit) {
    return (std::bit_cast<typename IntegerOf<T>::type>(x) >> bit) & 1;
}
template <class T, int W>
HYPERTUNA_INLINE Mask<T, W> rounded_bit(Lanes<T, W> x, int bit) {
    using Bits = typename Mask<T, W>::Vector;
    return {(((Bits)x.v >> bit) & 1) != 0};
}

template <class S>
HYPERTUNA_INLINE SinCos<S> sincos(const S& x) {
    using R = Reduction<base_t<S>>;
    using T = base_t<S>;
    const S rounded = x * S(T(2 / pi)) + S(R::round);
    const S k = rounded - S(R::round);
    const S r = ((x - k * S(R::high)) - k * S(R::middle)) - k * S(R::low);
    const S z = r * r;

    S s = S(T(1.589470394861289e-10));
    for (T a : {T(-2.505071641926113e-08), T(2.7557313372899235e-06), T(-1.984126982864022e-04),
                T(8.333333333320349e-03), T(-0.16666666666666616)})
        s = s * z + S(a);
    s = r + r * (z * s);

    S c = S(T(-1.13533562773752e-11));
    for (T a : {T(2.0875581912267723e-09), T(-2.755731309412236e-07), T(2.480158728386701e-05),
                T(-1.3888888888861067e-03), T(0.04166666666666645), T(-0.5)})
        c = c * z + S(a);
    c = S(1) + z * c;

    // Quadrant: odd multiples of pi/2 swap sine and cosine, and each changes sign every second quadrant.
    const auto odd = rounded_bit(rounded, 0);
    const auto second = rounded_bit(rounded, 1);
    const S sine = select(odd, c, s);
    const S cosine = select(odd, s, c);
    return {select(second, -sine, sine), select(rounded_bit(rounded + S(1), 1), -cosine, cosine)};
}

template <class S, int N>
HYPERTUNA_INLINE SinCos<Dual<S, N>> sincos(const Dual<S, N>& x) {
    const SinCos<S> at = sincos(x.v);
    return {Dual<S, N>::chain(at.sin, at.cos, x), Dual<S, N>::chain(at.cos, -at.sin, x)};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
