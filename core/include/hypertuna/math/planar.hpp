/// Vectors of planar rigid-body mechanics: two translations and one rotation.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Planar {
    static constexpr int size = 3;
    S x, y, z;  // along x, along y, about z

    friend HYPERTUNA_INLINE Planar operator+(const Planar& a, const Planar& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend HYPERTUNA_INLINE Planar operator-(const Planar& a, const Planar& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    template <class A>
        requires requires(A a, S s) { a * s; }
    friend HYPERTUNA_INLINE Planar operator*(const A& a, const Planar& b) {
        return {a * b.x, a * b.y, a * b.z};
    }
};

// All vectors are in body axes and refer to the nose: x from nose to tail, y to the left of x, z out of the plane.
template <class S>
using Twist = Planar<S>;  // xi = (u, v, r): velocity of the nose, m/s, and rate of turn, rad/s
template <class S>
using Wrench = Planar<S>;  // (F_x, F_y, N): force, N, and moment about the nose, N m
template <class S>
using Momentum = Planar<S>;  // P = (p_x, p_y, l): momentum, N s, and its moment about the nose, N m s

/// The k-th component.
template <class S>
HYPERTUNA_INLINE S& component(Planar<S>& a, int k) {
    return k == 0 ? a.x : k == 1 ? a.y : a.z;
}

/// The same vector with a wider scalar, such as a Dual of S.
template <class S, class A>
HYPERTUNA_INLINE Planar<S> widen(const Planar<A>& a) {
    return {S(a.x), S(a.y), S(a.z)};
}

/// A symmetric 3 x 3 matrix.
template <class S>
struct Symmetric {
    S xx, xy, xz, yy, yz, zz;

    template <class V>
    friend HYPERTUNA_INLINE Planar<V> operator*(const Symmetric& a, const Planar<V>& b) {
        return {a.xx * b.x + a.xy * b.y + a.xz * b.z, a.xy * b.x + a.yy * b.y + a.yz * b.z,
                a.xz * b.x + a.yz * b.y + a.zz * b.z};
    }
};

template <class S>
inline Symmetric<S> inverse(const Symmetric<S>& a) {
    const S xx = a.yy * a.zz - a.yz * a.yz;
    const S xy = a.xz * a.yz - a.xy * a.zz;
    const S xz = a.xy * a.yz - a.xz * a.yy;
    const S scale = S(1) / (a.xx * xx + a.xy * xy + a.xz * xz);
    return {scale * xx,
            scale * xy,
            scale * xz,
            scale * (a.xx * a.zz - a.xz * a.xz),
            scale * (a.xy * a.xz - a.xx * a.yz),
            scale * (a.xx * a.yy - a.xy * a.xy)};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
