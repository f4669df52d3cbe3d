/// The tail: a swimmer whose joints are moved by moments, not by a prescribed motion.
///
/// D coordinates q bend it, one for each joint group and one for a passive hinge. The joint in front of link i stands
/// at share[i] . q, so that link i moves with the twist xi + sum_d screw_id q'_d. Inverse dynamics at zero acceleration
/// gives the bias h of
///     M (xi', q'') = (0, moment) - h,    M = sum_i V_i^T Lambda_i V_i,
/// where the columns of V_i are the velocities of link i at unit u, v, r and unit q'.
#pragma once

#include "swimmer.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A swimmer with D free coordinates and the memory for its shape, each array one entry per link.
template <class S, class Law, int D>
struct Tail {
    Swimmer<S, Law> fish;
    const S (*share)[D];  // part of each coordinate that the joint in front of a link takes
    bool clamped;         // head held still, as on the bench
    JointMotion<S>* joint;
    LinkShape<S>* shape;
    LinkAcceleration<S>* acceleration;
};

/// Coordinates of the tail: bend of every joint group, then the hinge.
template <class S, int D>
struct Bend {
    S angle[D];  // rad
    S rate[D];   // rad/s
};

/// What forward dynamics gives.
template <class S, int D>
struct TailAcceleration {
    Twist<S> twist;  // d(xi)/dt in body axes
    S bend[D];       // rad/s^2
};

/// Solve A x = b in place, A symmetric and positive definite, of which the lower triangle is read and overwritten:
/// Cholesky's L L^T.
template <class S, int N>
HYPERTUNA_INLINE void solve_cholesky(S (&a)[N][N], S (&b)[N]) {
    HYPERTUNA_UNROLL
    for (int j = 0; j < N; ++j) {
        for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
        const S scale = S(1) / sqrt(a[j][j]);
        a[j][j] = scale;  // the inverse of L's diagonal
        for (int i = j + 1; i < N; ++i) {
            for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] *= scale;
        }
    }
    for (int i = 0; i < N; ++i) {
        for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
        b[i] *= a[i][i];
    }
    for (int i = N - 1; i >= 0; --i) {
        for (int k = i + 1; k < N; ++k) b[i] -= a[k][i] * b[k];
        b[i] *= a[i][i];
    }
}

/// Bend the body: shape and its acceleration while the coordinates' rates stay as they are.
template <class S, class Law, int D>
HYPERTUNA_INLINE void bend_tail(const Tail<S, Law, D>& tail, const Bend<S, D>& bend) {
    for (int i = 0; i < tail.fish.links; ++i) {
        JointMotion<S> motion{S(0), S(0), S(0)};
        for (int d = 0; d < D; ++d) {
            motion.angle += tail.share[i][d] * bend.angle[d];
            motion.rate += tail.share[i][d] * bend.rate[d];
        }
        tail.joint[i] = motion;
    }
    shape(tail.fish.links, tail.fish.link, tail.joint, tail.shape, tail.acceleration);
}

/// Accelerations under moments on the coordinates [N m], by forward dynamics. Leaves the shape in the tail's memory.
template <class S, class Law, int D>
TailAcceleration<S, D> tail_acceleration(const Tail<S, Law, D>& tail, const Bend<S, D>& bend, const Twist<S>& xi,
                                         const S (&moment)[D]) {
    constexpr int N = 3 + D;
    bend_tail(tail, bend);
    const Composite<S> unused{};  // link_load asks for the shape alone
    const Instant<S> now{tail.shape, tail.acceleration, unused.inertia, unused.momentum};
    S matrix[N][N] = {}, load[N] = {};
    Twist<S> screw[D] = {};  // twist of the link at unit rate of each coordinate
    for (int d = 0; d < D; ++d) load[3 + d] = moment[d];
    for (int i = 0; i < tail.fish.links; ++i) {
        const LinkShape<S>& at = tail.shape[i];
        const LinkInertia<S>& inertia = tail.fish.water.inertia(i);
        const Planar<S> joint = joint_position(at, tail.fish.link[i]);
        Along<S> column[N] = {{at.c, -at.s, S(0)}, {at.s, at.c, S(0)}, {at.h_t, at.h_n, S(1)}};
        const Wrench<S> bias = link_load(tail.fish, now, i, xi);
        load[0] -= bias.x, load[1] -= bias.y, load[2] -= bias.z;
        for (int d = 0; d < D; ++d) {
            const S share = tail.share[i][d];
            screw[d] = screw[d] + Twist<S>{share * joint.y, -share * joint.x, share};
            column[3 + d] = at.along(screw[d]);
            load[3 + d] -= screw[d].x * bias.x + screw[d].y * bias.y + screw[d].z * bias.z;
        }
        for (int j = 0; j < N; ++j) {
            const Along<S> p = inertia * column[j];
            for (int k = j; k < N; ++k) matrix[k][j] += column[k].t * p.t + column[k].n * p.n + column[k].w * p.w;
        }
    }
    if (tail.clamped)
        for (int j = 0; j < 3; ++j) {
            for (int k = j; k < N; ++k) matrix[k][j] = S(k == j);
            load[j] = S(0);
        }
    solve_cholesky(matrix, load);
    TailAcceleration<S, D> out{{load[0], load[1], load[2]}, {}};
    for (int d = 0; d < D; ++d) out.bend[d] = load[3 + d];
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
