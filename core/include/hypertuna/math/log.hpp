/// Logarithm of 1 + x from + - * / alone: without contraction to fused multiply-adds, every machine and every lane gets
/// the same bits. Less than 1.25 units in the last place off.
///
/// 1 + x = 2^k m with m in [sqrt(1/2), sqrt(2)); what the sum rounded away is added again. With s = f / (2 + f) and
/// f = m - 1, log m = 2 artanh s, of which a polynomial in s^2 is minimax there (Tang 1990; fdlibm's coefficients).
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// x = 2^exponent * part, part in [sqrt(1/2), sqrt(2)), of a positive normal number.
template <class S>
struct Parts {
    S exponent, part;
};

inline constexpr std::uint64_t log_offset = 0x3fe6a09e667f3bcd;    // bits of sqrt(1/2)
inline constexpr std::uint64_t log_one = 0x3ff0000000000000;       // bits of 1: an exponent of 1023
inline constexpr std::uint64_t log_mantissa = 0x000fffffffffffff;  // bits below the exponent
inline constexpr std::uint64_t log_integer = 0x4330000000000000;   // bits of 2^52, which lead a whole number's
inline constexpr double log_unbias = 4503599627370496.0 + 1023.0;  // 2^52, and the exponent of 1

HYPERTUNA_INLINE Parts<double> parts(double x) {
    const std::uint64_t above = std::bit_cast<std::uint64_t>(x) + (log_one - log_offset);
    return {std::bit_cast<double>((above >> 52) + log_integer) - log_unbias,
            std::bit_cast<double>((above & log_mantissa) + log_offset)};
}
template <int W>
HYPERTUNA_INLINE Parts<Lanes<double, W>> parts(Lanes<double, W> x) {
    using Bits = typename VectorOf<std::uint64_t, W>::type;
    using Vector = typename Lanes<double, W>::Vector;
    const Bits above = (Bits)x.v + (log_one - log_offset);
    return {Lanes<double, W>((Vector)((above >> 52) + log_integer)) - Lanes<double, W>(log_unbias),
            Lanes<double, W>((Vector)((above & log_mantissa) + log_offset))};
}

/// NaN where x is below -1 or NaN.
template <class S>
HYPERTUNA_INLINE S log1p_of(const S& x) {
    const S one(1.0), sum = one + x;
    const auto [k, m] = parts(sum);
    const S f = m - one, wide = S(2.0) + f, over = one / (wide * sum);
    const S lost = select(x < one, x - (sum - one), one - (sum - x)) * (wide * over);
    const S s = f * (sum * over), z = s * s, half_square = S(0.5) * f * f;
    const S z2 = z * z, low = S(0.6666666666666735130) + S(0.3999999999940941908) * z;
    const S middle = S(0.2857142874366239149) + S(0.2222219843214978396) * z;
    const S high = S(0.1818357216161805012) + S(0.1531383769920937332) * z + S(0.1479819860511658591) * z2;
    const S r = low + z2 * (middle + z2 * high);
    const S small = s * (half_square + r * z) + (k * S(1.90821492927058770002e-10) + lost);
    const S log = k * S(6.93147180369123816490e-01) - ((half_square - small) - f);
    return select(S(-1.0) < x, log, (x - x) / (x - x));
}
template <std::same_as<double> S>
HYPERTUNA_INLINE S log1p(S x) {
    return log1p_of(x);
}
template <std::same_as<float> S>
HYPERTUNA_INLINE S log1p(S x) {
    return std::log1p(x);
}
template <int W>
HYPERTUNA_INLINE Lanes<double, W> log1p(const Lanes<double, W>& x) {
    return log1p_of(x);
}
template <class S, int N>
HYPERTUNA_INLINE Dual<S, N> log1p(const Dual<S, N>& x) {
    return Dual<S, N>::chain(log1p(x.v), S(1) / (S(1) + x.v), x);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
