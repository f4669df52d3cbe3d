/// Vectors of rigid-body mechanics in space: twists, wrenches, and attitudes as unit quaternions.
///
/// Body axes: x from nose to tail, y to starboard, z up. World: x east, y north, z up, the surface of the water at
/// z = 0. An attitude turns body axes into world axes.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Vector {
    S x, y, z;

    friend HYPERTUNA_INLINE Vector operator+(const Vector& a, const Vector& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend HYPERTUNA_INLINE Vector operator-(const Vector& a, const Vector& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    template <class A>
        requires requires(A a, S s) { a * s; }
    friend HYPERTUNA_INLINE Vector operator*(const A& a, const Vector& b) {
        return {a * b.x, a * b.y, a * b.z};
    }
};

template <class S>
HYPERTUNA_INLINE S component(const Vector<S>& v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : v.z;
}
template <class S>
HYPERTUNA_INLINE S dot(const Vector<S>& a, const Vector<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class S>
HYPERTUNA_INLINE Vector<S> cross(const Vector<S>& a, const Vector<S>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A linear and an angular vector: velocity and rate of turn, force and moment, or momentum and its moment.
template <class S>
struct Spatial {
    Vector<S> linear, angular;

    friend HYPERTUNA_INLINE Spatial operator+(const Spatial& a, const Spatial& b) {
        return {a.linear + b.linear, a.angular + b.angular};
    }
    template <class A>
        requires requires(A a, S s) { a * s; }
    friend HYPERTUNA_INLINE Spatial operator*(const A& a, const Spatial& b) {
        return {a * b.linear, a * b.angular};
    }
};
/// Velocity of the nose through the water, m/s, and rate of turn of the head, rad/s, in body axes.
template <class S>
using SpatialTwist = Spatial<S>;
/// Force, N, and moment about the nose, N m, in body axes. Momenta [N s, N m s] use the same type.
template <class S>
using SpatialWrench = Spatial<S>;

/// Quaternion w + x i + y j + z k.
template <class S>
struct Quaternion {
    S w, x, y, z;

    friend HYPERTUNA_INLINE Quaternion operator+(const Quaternion& a, const Quaternion& b) {
        return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
    }
    template <class A>
        requires requires(A a, S s) { a * s; }
    friend HYPERTUNA_INLINE Quaternion operator*(const A& a, const Quaternion& b) {
        return {a * b.w, a * b.x, a * b.y, a * b.z};
    }
};

template <class S>
HYPERTUNA_INLINE S squared_norm(const Quaternion<S>& q) {
    return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
}
template <class S>
HYPERTUNA_INLINE Quaternion<S> normalized(const Quaternion<S>& q) {
    return (S(1) / sqrt(squared_norm(q))) * q;
}

/// Time derivative of an attitude at the rate of turn omega in body axes: q' = 1/2 q omega.
template <class S>
HYPERTUNA_INLINE Quaternion<S> attitude_rate(const Quaternion<S>& q, const Vector<S>& rate) {
    const S half = S(base_t<S>(0.5)), x = half * rate.x, y = half * rate.y, z = half * rate.z;
    return {S(0) - q.x * x - q.y * y - q.z * z, q.w * x + q.y * z - q.z * y, q.w * y + q.z * x - q.x * z,
            q.w * z + q.x * y - q.y * x};
}

/// Rotation matrix from body to world axes: its rows are the world's axes in body axes, its columns the body's axes in
/// world axes.
template <class S>
struct Rotation {
    Vector<S> east, north, up;
};

/// Rotation matrix of a quaternion of any length: between two normalizations an integrated one is not quite of length
/// 1.
template <class S>
HYPERTUNA_INLINE Rotation<S> rotation(const Quaternion<S>& q) {
    const S s = S(2) / squared_norm(q), one(1);
    const S xx = s * q.x * q.x, yy = s * q.y * q.y, zz = s * q.z * q.z;
    const S xy = s * q.x * q.y, xz = s * q.x * q.z, yz = s * q.y * q.z;
    const S wx = s * q.w * q.x, wy = s * q.w * q.y, wz = s * q.w * q.z;
    return {{one - yy - zz, xy - wz, xz + wy}, {xy + wz, one - xx - zz, yz - wx}, {xz - wy, yz + wx, one - xx - yy}};
}
template <class S>
HYPERTUNA_INLINE Vector<S> to_world(const Rotation<S>& r, const Vector<S>& v) {
    return {dot(r.east, v), dot(r.north, v), dot(r.up, v)};
}
template <class S>
HYPERTUNA_INLINE Vector<S> to_body(const Rotation<S>& r, const Vector<S>& v) {
    return v.x * r.east + v.y * r.north + v.z * r.up;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
