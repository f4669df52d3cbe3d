/// Lanes: W numbers side by side in one vector register, so that one instruction serves W gaits.
#pragma once

#include <cstdint>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T, int W>
struct VectorOf {
    typedef T type __attribute__((vector_size(sizeof(T) * W)));
};
template <class T>
struct IntegerOf;
template <>
struct IntegerOf<double> {
    using type = std::int64_t;
};
template <>
struct IntegerOf<float> {
    using type = std::int32_t;
};

/// All bits of a lane set where a comparison holds, none elsewhere.
template <class T, int W>
struct Mask {
    using Vector = typename VectorOf<typename IntegerOf<T>::type, W>::type;
    Vector v;

    friend HYPERTUNA_INLINE Mask operator&(Mask a, Mask b) { return {a.v & b.v}; }
    friend HYPERTUNA_INLINE Mask operator|(Mask a, Mask b) { return {a.v | b.v}; }
    friend HYPERTUNA_INLINE Mask operator!(Mask a) { return {~a.v}; }
};

template <class T, int W>
HYPERTUNA_INLINE bool any(Mask<T, W> mask) {
    bool result = false;
    for (int k = 0; k < W; ++k) result |= mask.v[k] != 0;
    return result;
}
template <class T, int W>
HYPERTUNA_INLINE bool all(Mask<T, W> mask) {
    return !any(!mask);
}

template <class T, int W>
struct Lanes {
    using Vector = typename VectorOf<T, W>::type;
    Vector v;

    Lanes() = default;
    HYPERTUNA_INLINE Lanes(Vector vector) : v(vector) {}
    HYPERTUNA_INLINE Lanes(T x) : v(Vector{} + x) {}

    HYPERTUNA_INLINE T operator[](int k) const { return v[k]; }
    HYPERTUNA_INLINE void set(int k, T x) { v[k] = x; }

    friend HYPERTUNA_INLINE Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
    friend HYPERTUNA_INLINE Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
    friend HYPERTUNA_INLINE Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
    friend HYPERTUNA_INLINE Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
    friend HYPERTUNA_INLINE Lanes operator-(Lanes a) { return -a.v; }
    HYPERTUNA_INLINE Lanes& operator+=(Lanes a) {
        v += a.v;
        return *this;
    }
    HYPERTUNA_INLINE Lanes& operator-=(Lanes a) {
        v -= a.v;
        return *this;
    }
    HYPERTUNA_INLINE Lanes& operator*=(Lanes a) {
        v *= a.v;
        return *this;
    }
    friend HYPERTUNA_INLINE Mask<T, W> operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
    friend HYPERTUNA_INLINE Mask<T, W> operator<=(Lanes a, Lanes b) { return {a.v <= b.v}; }
    friend HYPERTUNA_INLINE Mask<T, W> operator!=(Lanes a, Lanes b) { return {a.v != b.v}; }
};

template <class T, int W>
struct Base<Lanes<T, W>> {
    using type = T;
};

template <class T, int W>
HYPERTUNA_INLINE Lanes<T, W> select(Mask<T, W> mask, Lanes<T, W> yes, Lanes<T, W> no) {
    return Lanes<T, W>(mask.v ? yes.v : no.v);
}

template <class T, int W>
HYPERTUNA_INLINE Lanes<T, W> abs(Lanes<T, W> x) {
    using Integer = typename IntegerOf<T>::type;
    using Bits = typename Mask<T, W>::Vector;
    constexpr Integer sign = Integer(1) << (8 * sizeof(T) - 1);
    return Lanes<T, W>((typename Lanes<T, W>::Vector)((Bits)x.v & ~(Bits{} + sign)));
}
template <class T, int W>
HYPERTUNA_INLINE Lanes<T, W> sqrt(Lanes<T, W> x) {
    Lanes<T, W> root;
    for (int k = 0; k < W; ++k) root.v[k] = std::sqrt(x.v[k]);
    return root;
}
template <class T, int W>
HYPERTUNA_INLINE Lanes<T, W> times_abs(Lanes<T, W> x) {
    return x * abs(x);
}
template <class T, int W>
HYPERTUNA_INLINE Lanes<T, W> value(Lanes<T, W> x) {
    return x;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
