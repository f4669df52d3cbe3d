/// The scalar of a kernel: as many lanes as a vector register of its instruction set holds, or a plain number.
#pragma once

#include "hypertuna/math/lanes.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

#if defined(__AVX512F__)
inline constexpr int lanes = 8;
#elif defined(__AVX__)
inline constexpr int lanes = 4;
#elif defined(__SSE4_2__) || defined(__aarch64__) || defined(__wasm_simd128__)
inline constexpr int lanes = 2;
#else
inline constexpr int lanes = 1;
#endif

template <int W>
struct Pack {
    using type = Lanes<double, W>;
};
template <>
struct Pack<1> {
    using type = double;
};
using Real = typename Pack<lanes>::type;

HYPERTUNA_INLINE double lane(double x, int) { return x; }
HYPERTUNA_INLINE void set_lane(double& x, int, double y) { x = y; }
template <int W>
HYPERTUNA_INLINE double lane(const Lanes<double, W>& x, int k) {
    return x[k];
}
template <int W>
HYPERTUNA_INLINE void set_lane(Lanes<double, W>& x, int k, double y) {
    x.set(k, y);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
