/// The body: a planar chain of rigid links, seen from its head.
///
/// Body axes: origin at the nose (front of link 0), x along link 0 from nose to tail, angles
/// counter-clockwise. Link i hangs at joint i, at its front end; psi_i is its angle from link 0.
#pragma once

#include "hypertuna/math/planar.hpp"
#include "hypertuna/swimming/gait.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Link {
    S length;   // m
    S com;      // m, center of mass behind the front joint
    S mass;     // kg
    S inertia;  // kg m^2, about the center of mass
};

/// Velocity in a link's own axes: along it (nose to tail), across it, and rate of turn.
/// Momentum, force and acceleration of a link use the same type.
template <class S>
struct Along {
    S t, n, w;
};

/// Geometry of one link, and how the change of shape moves it: everything the swimming equations need of a link.
///
/// The link's velocity is J xi + a, with the body's twist xi = (u, v, r) and
///     J = [ c  s  h_t ]        a = (a_t, a_n, w)
///         [-s  c  h_n ]
///         [ 0  0   1  ]
template <class S>
struct LinkShape {
    S c, s;      // cos psi, sin psi
    S h_t, h_n;  // moment arms about the nose of a force along and across the link at its center of mass, m
    S a_t, a_n;  // velocity of the center of mass by the change of shape, m/s
    S w;         // rate of psi, rad/s

    /// J xi: velocity of the link as a part of the rigid body.
    template <class V>
    HYPERTUNA_INLINE Along<V> along(const Twist<V>& xi) const {
        return {c * xi.x + s * xi.y + h_t * xi.z, c * xi.y - s * xi.x + h_n * xi.z, xi.z};
    }
    template <class V>
    HYPERTUNA_INLINE Along<V> velocity(const Twist<V>& xi) const {
        return {c * xi.x + s * xi.y + h_t * xi.z + a_t, c * xi.y - s * xi.x + h_n * xi.z + a_n, xi.z + w};
    }
    /// a: velocity of the link by the change of shape alone.
    HYPERTUNA_INLINE Along<S> bending() const { return {a_t, a_n, w}; }
    /// J^T f: a force on the link, as a wrench at the nose.
    template <class V>
    HYPERTUNA_INLINE Wrench<V> wrench(const Along<V>& f) const {
        return {c * f.t - s * f.n, s * f.t + c * f.n, h_t * f.t + h_n * f.n + f.w};
    }
    /// Add J^T f to a sum, one multiply-add per term.
    template <class V>
    HYPERTUNA_INLINE void add_wrench(const Along<V>& f, Wrench<V>& sum) const {
        sum = {sum.x + c * f.t - s * f.n, sum.y + s * f.t + c * f.n, sum.z + h_t * f.t + h_n * f.n + f.w};
    }
};

/// Acceleration of one link by the change of shape alone, along and across it (m/s^2), and of psi (rad/s^2).
template <class S>
using LinkAcceleration = Along<S>;

/// Shape of the body from its joint motions: one recursion from nose to tail. direction(i) is sine and cosine of psi_i;
/// it is called once for each link in turn.
template <class S, class Direction>
HYPERTUNA_INLINE void shape(int links, const Link<S>* link, const JointMotion<S>* joint, LinkShape<S>* out,
                            LinkAcceleration<S>* acceleration, Direction&& direction) {
    S psi_rate(0), psi_acceleration(0);
    // The front joint of link i: position, velocity, acceleration by shape.
    S x(0), y(0), vx(0), vy(0), gx(0), gy(0);
    for (int i = 0; i < links; ++i) {
        psi_rate += joint[i].rate;
        psi_acceleration += joint[i].acceleration;
        const auto [s, c] = direction(i);
        const S w = psi_rate, w2 = psi_rate * psi_rate, e = psi_acceleration;

        const S com = link[i].com;
        LinkShape<S>& o = out[i];
        o.c = c;
        o.s = s;
        o.h_t = x * s - y * c;
        o.h_n = x * c + y * s + com;
        o.a_t = c * vx + s * vy;
        o.a_n = c * vy - s * vx + com * w;
        o.w = w;
        acceleration[i] = {c * gx + s * gy - com * w2, c * gy - s * gx + com * e, e};

        const S l = link[i].length;
        x += l * c;
        y += l * s;
        vx -= l * w * s;
        vy += l * w * c;
        gx -= l * (e * s + w2 * c);
        gy += l * (e * c - w2 * s);
    }
}

template <class S>
void shape(int links, const Link<S>* link, const JointMotion<S>* joint, LinkShape<S>* out,
           LinkAcceleration<S>* acceleration) {
    S psi(0);
    shape(links, link, joint, out, acceleration, [&](int i) {
        psi += joint[i].angle;
        return sincos(psi);
    });
}

/// Rate of joint i, rad/s: difference of the rates of its two links.
template <class S>
HYPERTUNA_INLINE S joint_rate(const LinkShape<S>* shape, int i) {
    return i == 0 ? S(0) : shape[i].w - shape[i - 1].w;
}

/// Position of a link's front joint in body axes, from the link's moment arms.
template <class S>
HYPERTUNA_INLINE Planar<S> joint_position(const LinkShape<S>& shape, const Link<S>& link) {
    const S along = shape.h_n - link.com;  // joint seen along the link, from the nose
    return {shape.c * along + shape.s * shape.h_t, shape.s * along - shape.c * shape.h_t, S(0)};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
