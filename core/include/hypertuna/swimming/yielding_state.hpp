/// State of a body with joints that yield, and the numbers that its motion is made of.
#pragma once

#include "hypertuna/swimming/settle.hpp"
#include "hypertuna/swimming/spring.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int max_hung = 32;  // links from the first joint that yields to the tail

/// Momentum of the body, and of each coordinate that yields its angle from rest and its momentum. As a change of the
/// motion: twist of the head, angles, rates.
template <class S, int D>
struct YieldingState {
    static constexpr int size = 3 + 2 * D;
    Planar<S> body;
    S angle[D];     // rad
    S momentum[D];  // N m s

    friend HYPERTUNA_INLINE YieldingState operator+(YieldingState a, const YieldingState& b) {
        a.body = a.body + b.body;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) a.angle[d] += b.angle[d], a.momentum[d] += b.momentum[d];
        return a;
    }
    template <class A>
    friend HYPERTUNA_INLINE YieldingState operator*(const A& a, YieldingState b) {
        b.body = a * b.body;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) b.angle[d] = a * b.angle[d], b.momentum[d] = a * b.momentum[d];
        return b;
    }
    friend HYPERTUNA_INLINE YieldingState operator-(const YieldingState& a, const YieldingState& b) {
        return a + S(base_t<S>(-1)) * b;
    }
};

template <class S, int D>
HYPERTUNA_INLINE S& component(YieldingState<S, D>& y, int k) {
    return k < 3 ? component(y.body, k) : k < 3 + D ? y.angle[k - 3] : y.momentum[k - 3 - D];
}
template <class S, int D>
HYPERTUNA_INLINE const S& component(const YieldingState<S, D>& y, int k) {
    return component(const_cast<YieldingState<S, D>&>(y), k);
}
template <class V, class S, int D>
HYPERTUNA_INLINE YieldingState<V, D> widen(const YieldingState<S, D>& y) {
    YieldingState<V, D> out{widen<V>(y.body), {}, {}};
    for (int d = 0; d < D; ++d) out.angle[d] = V(y.angle[d]), out.momentum[d] = V(y.momentum[d]);
    return out;
}
template <class S, int D, class M>
HYPERTUNA_INLINE YieldingState<S, D> select(const M& mask, const YieldingState<S, D>& yes, YieldingState<S, D> no) {
    no.body = select(mask, yes.body, no.body);
    for (int d = 0; d < D; ++d) {
        no.angle[d] = select(mask, yes.angle[d], no.angle[d]);
        no.momentum[d] = select(mask, yes.momentum[d], no.momentum[d]);
    }
    return no;
}

/// How the coordinates swing over a beat, from rest: mean + sine sin(2 pi f t) + cosine cos(2 pi f t) and harmonics;
/// the largest angles of their hinges, and what their dampers and stops take.
template <class S, int D>
struct Swinging {
    S mean[D], sine[D], cosine[D], peak[D];  // rad
    S damping[D];                            // W
};

/// A joint that yields: its place, and its velocity by the prescribed joints; of all that hangs behind it, the inertia
/// and the momentum that the prescribed joints give.
template <class S>
struct HungJoint {
    S x, y, v_x, v_y;
    Symmetric<S> inertia;
    Momentum<S> brought;

    /// Twist of what hangs behind it, at a unit rate.
    HYPERTUNA_INLINE Twist<S> screw() const { return {y, -x, S(1)}; }
    /// Change of a wrench or a momentum that turns about the joint, per angle.
    HYPERTUNA_INLINE Wrench<S> turn(const Wrench<S>& a) const { return {-a.y, a.x, x * a.x + y * a.y}; }
};

/// How a joint that yields moves, and what hangs behind it.
template <class S>
struct HungMotion {
    Twist<S> twist, yielding;    // of links up to the next joint that yields, and the part of it by joints that yield
    S v_x, v_y, bend_x, bend_y;  // velocity of the joint, and the part of it that the change of shape makes
    Momentum<S> momentum;        // of all that hangs behind it

    /// Change of the twist of all that hangs behind it, as it sees itself, per angle; and of the part by bending.
    HYPERTUNA_INLINE Twist<S> turning() const { return {v_y, -v_x, S(0)}; }
    HYPERTUNA_INLINE Twist<S> bending() const { return {bend_y, -bend_x, S(0)}; }
    /// Velocity of a link by the change of shape alone.
    HYPERTUNA_INLINE Along<S> bend_of(const LinkShape<S>& link) const {
        const Along<S> a = link.bending(), more = link.along(yielding);
        return {a.t + more.t, a.n + more.n, a.w + more.w};
    }
};

/// The links that hang behind the first joint that yields, and the joints that do. The velocity of a link's shape is
/// that by the prescribed joints alone.
template <class S, int D>
struct Hung {
    LinkShape<S> link[max_hung];
    HungJoint<S> joint[D];
};

/// How a body moves whose joints yield: twist of the head and rates. They solve the equations of momenta, of which it
/// keeps M^-1, C, M^-1 C and the inertia that the free body opposes to a joint, B - C^T M^-1 C, lower triangle.
template <class S, int D>
struct Moving {
    Twist<S> xi;
    S rate[D];
    Symmetric<S> mobility;
    Momentum<S> cross[D];
    Twist<S> carried[D];
    S reduced[D][D];
};

/// Solve A x = b in place, A symmetric and positive definite, of which the lower triangle is read.
template <class S, int D>
HYPERTUNA_INLINE void solve_positive(S (&a)[D][D], S (&b)[D]) {
    for (int j = 0; j < D; ++j)
        for (int i = j + 1; i < D; ++i) {
            const S l = a[i][j] / a[j][j];
            for (int k = j + 1; k <= i; ++k) a[i][k] -= l * a[k][j];
            b[i] -= l * b[j];
        }
    for (int j = D - 1; j >= 0; --j) {
        for (int i = j + 1; i < D; ++i) b[j] -= a[i][j] * b[i];
        b[j] = b[j] / a[j][j];
    }
}

template <class S>
HYPERTUNA_INLINE S dotted(const Planar<S>& a, const Planar<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class S>
HYPERTUNA_INLINE Symmetric<S> operator+(const Symmetric<S>& a, const Symmetric<S>& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
