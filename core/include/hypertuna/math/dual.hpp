/// Dual numbers: a value with its derivatives in N directions, so that any function of the core also
/// gives exact derivatives (forward mode).
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S, int N>
struct Dual {
    S v;     // value
    S d[N];  // derivative in each direction

    Dual() = default;
    HYPERTUNA_INLINE Dual(const S& x) : v(x) { HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) d[k] = S(0); }
    HYPERTUNA_INLINE Dual(base_t<S> x)
        requires(!std::same_as<S, base_t<S>>)
        : Dual(S(x)) {}

    /// The result of a function with value f and slope df at x.
    static HYPERTUNA_INLINE Dual chain(const S& f, const S& df, const Dual& x) {
        Dual y;
        y.v = f;
        HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = df * x.d[k];
        return y;
    }

    friend HYPERTUNA_INLINE Dual operator+(const Dual& a, const Dual& b) {
        Dual y;
        y.v = a.v + b.v;
        HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = a.d[k] + b.d[k];
        return y;
    }
    friend HYPERTUNA_INLINE Dual operator-(const Dual& a, const Dual& b) {
        Dual y;
        y.v = a.v - b.v;
        HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = a.d[k] - b.d[k];
        return y;
    }
    friend HYPERTUNA_INLINE Dual operator*(const Dual& a, const Dual& b) {
        Dual y;
        y.v = a.v * b.v;
        HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = a.d[k] * b.v + a.v * b.d[k];
        return y;
    }
    friend HYPERTUNA_INLINE Dual operator/(const Dual& a, const Dual& b) {
        const S inverse = S(1) / b.v;
        Dual y;
        y.v = a.v * inverse;
        HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = (a.d[k] - y.v * b.d[k]) * inverse;
        return y;
    }
    friend HYPERTUNA_INLINE Dual operator-(const Dual& a) { return chain(-a.v, S(-1), a); }

    // Operations with a number that has no derivatives take a quarter of the work for N = 3.
    friend HYPERTUNA_INLINE Dual operator+(Dual a, const S& b) {
        a.v += b;
        return a;
    }
    friend HYPERTUNA_INLINE Dual operator+(const S& a, Dual b) {
        b.v += a;
        return b;
    }
    friend HYPERTUNA_INLINE Dual operator-(Dual a, const S& b) {
        a.v -= b;
        return a;
    }
    friend HYPERTUNA_INLINE Dual operator-(const S& a, const Dual& b) { return chain(a - b.v, S(-1), b); }
    friend HYPERTUNA_INLINE Dual operator*(const Dual& a, const S& b) { return chain(a.v * b, b, a); }
    friend HYPERTUNA_INLINE Dual operator*(const S& a, const Dual& b) { return chain(a * b.v, a, b); }
    friend HYPERTUNA_INLINE Dual operator/(const Dual& a, const S& b) { return a * (S(1) / b); }

    HYPERTUNA_INLINE Dual& operator+=(const Dual& a) { return *this = *this + a; }
    HYPERTUNA_INLINE Dual& operator-=(const Dual& a) { return *this = *this - a; }

    // Comparisons use only the values.
    friend HYPERTUNA_INLINE auto operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
    friend HYPERTUNA_INLINE auto operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
};

template <class S, int N>
struct Base<Dual<S, N>> {
    using type = base_t<S>;
};

template <class M, class S, int N>
HYPERTUNA_INLINE Dual<S, N> select(const M& mask, const Dual<S, N>& yes, const Dual<S, N>& no) {
    Dual<S, N> y;
    y.v = select(mask, yes.v, no.v);
    HYPERTUNA_UNROLL for (int k = 0; k < N; ++k) y.d[k] = select(mask, yes.d[k], no.d[k]);
    return y;
}
template <class S, int N>
HYPERTUNA_INLINE Dual<S, N> abs(const Dual<S, N>& x) {
    return Dual<S, N>::chain(abs(x.v), select(x.v < S(0), S(-1), S(1)), x);
}
template <class S, int N>
HYPERTUNA_INLINE Dual<S, N> sqrt(const Dual<S, N>& x) {
    const S root = sqrt(x.v);
    return Dual<S, N>::chain(root, S(0.5) / root, x);
}
template <class S, int N>
HYPERTUNA_INLINE Dual<S, N> times_abs(const Dual<S, N>& x) {
    const S magnitude = abs(x.v);
    return Dual<S, N>::chain(x.v * magnitude, magnitude + magnitude, x);
}
template <class S, int N>
HYPERTUNA_INLINE S value(const Dual<S, N>& x) {
    return x.v;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
