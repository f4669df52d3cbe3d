/// Logarithm of a quotient from + - * / alone: without contraction to fused multiply-adds, every machine and every lane
/// gets the same bits. The error is below 2.5 units in the last place.
///
/// With n / d = 2^k m and m in [2/3, 3/2], log m = 2 artanh s of s = (m - 1) / (m + 1): a minimax polynomial in s^2 of
/// relative error 2e-17.
#pragma once

#include <limits>

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A power of two and its exponent.
template <class S>
struct Power {
    S exponent, power;
};

inline constexpr std::uint64_t log_one = 0x3ff0000000000000;  // bits of 1.0, whose biased exponent is 1023
inline constexpr std::uint64_t log_half =
    0x0008000000000000;  // half a step of the exponent, added to round to the nearest power
inline constexpr std::uint64_t log_integer =
    0x4330000000000000;  // bits of 2^52: added to an integer below 2^52, they make the bits of 2^52 plus the integer
inline constexpr double log_unbias = 4503599627370496.0 + 1023.0;  // 2^52 plus the bias of the exponent

/// The power of two nearest to the quotient n / d of positive normal numbers, from their bits: read as integers, these
/// rise with the logarithm.
HYPERTUNA_INLINE Power<double> nearest_power(double n, double d) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(n) - std::bit_cast<std::uint64_t>(d) + log_one + log_half;
    return {std::bit_cast<double>((bits >> 52) + log_integer) - log_unbias, std::bit_cast<double>(bits >> 52 << 52)};
}
template <int W>
HYPERTUNA_INLINE Power<Lanes<double, W>> nearest_power(Lanes<double, W> n, Lanes<double, W> d) {
    using Bits = typename VectorOf<std::uint64_t, W>::type;
    using Vector = typename Lanes<double, W>::Vector;
    const Bits bits = (Bits)n.v - (Bits)d.v + (log_one + log_half);
    return {Lanes<double, W>((Vector)((bits >> 52) + log_integer)) - Lanes<double, W>(log_unbias),
            Lanes<double, W>((Vector)(bits >> 52 << 52))};
}

template <class S>
HYPERTUNA_INLINE S log_quotient_of(const S& n, const S& d, const S& difference) {
    const auto [k, power] = nearest_power(n, d);
    const S whole = power * d, part = select(power != S(1.0), n - whole, difference);
    const S s = part / (part + (whole + whole)), z = s * s, z2 = z * z,
            low = S(0.66666666666672900) + S(0.39999999996057767) * z;
    const S middle = S(0.28571429414190550) + S(0.22222136941086196) * z;
    const S high = S(0.18186420537227735) + S(0.15248889498527940) * z + S(0.15378354023905210) * z2;
    const S log = k * S(0.69314718055994530942) + (s + s + s * z * (low + z2 * (middle + z2 * high)));
    return select(S(0.0) < n, log, S(std::numeric_limits<double>::quiet_NaN()));
}

/// log(n / d) for d > 0; NaN where n is not positive. `difference` is n - d without the rounding errors of n and d:
/// where it is 0, so is the result.
template <std::same_as<double> S>
HYPERTUNA_INLINE S log_quotient(S n, S d, S difference) {
    return log_quotient_of(n, d, difference);
}
template <std::same_as<float> S>
HYPERTUNA_INLINE S log_quotient(S, S d, S difference) {
    return std::log1p(difference / d);
}
template <int W>
HYPERTUNA_INLINE Lanes<double, W> log_quotient(const Lanes<double, W>& n, const Lanes<double, W>& d,
                                               const Lanes<double, W>& difference) {
    return log_quotient_of(n, d, difference);
}
template <class S, int N>
HYPERTUNA_INLINE Dual<S, N> log_quotient(const Dual<S, N>& n, const Dual<S, N>& d, const Dual<S, N>& difference) {
    const S over_n = S(1) / n.v, over_d = S(1) / d.v;
    Dual<S, N> y;
    y.v = log_quotient(n.v, d.v, difference.v);
    HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = n.d[k] * over_n - d.d[k] * over_d;
    return y;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
