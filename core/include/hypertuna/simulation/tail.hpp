/// The tail: a swimmer whose joints are moved by moments, not by a prescribed motion.
///
/// D coordinates q bend it, one for each joint group and one for each passive hinge. The joint in front of link i
/// stands at share[i] . q, so that link i moves with the twist xi + sum_d screw_id q'_d. Inverse dynamics at zero
/// acceleration gives the bias h of
///     M (xi', q'') = (0, moment) - h,
/// and M is the mass matrix, summed up over the links.
#pragma once

#include "hypertuna/swimming/stepping.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Tags for where a body moves: in the plane, or in space.
struct InPlane;
struct InSpace;

/// Types of the head's twist and pose in the plane or in space.
template <class S, class Space>
struct HeadOf;
template <class S>
struct HeadOf<S, InPlane> {
    using Twist = hypertuna::Twist<S>;
    using Pose = hypertuna::Pose<S>;
};

/// A swimmer with D free coordinates and the memory for its shape, each array one entry per link.
template <class S, class Law, int D>
struct Tail {
    using Scalar = S;
    using Space = InPlane;
    static constexpr int coordinates = D;

    Swimmer<S, Law> fish;
    const S (*share)[D];  // part of each coordinate that the joint in front of a link takes
    bool clamped;         // head held still, as on the bench
    const S*
        armature;  // kg m^2: inertia that turns with each coordinate in addition to the links, that of a servo's rotor
    JointMotion<S>* joint;
    LinkShape<S>* shape;
    LinkAcceleration<S>* acceleration;
};

/// Coordinates of the tail: bend of every joint group, then of every hinge.
template <class S, int D>
struct Bend {
    S angle[D];  // rad
    S rate[D];   // rad/s
};

/// Result of forward dynamics.
template <class S, int D>
struct TailAcceleration {
    Twist<S> twist;  // d(xi)/dt in body axes
    S bend[D];       // rad/s^2
};

/// Solve A x = b in place, A symmetric and positive definite, of which the lower triangle is read and overwritten:
/// Cholesky's method without roots, L D L^T.
template <class S, int N>
HYPERTUNA_INLINE void solve_cholesky(S (&a)[N][N], S (&b)[N]) {
    HYPERTUNA_UNROLL
    for (int j = 0; j < N; ++j) {
        a[j][j] = S(1) / a[j][j];  // inverted diagonal element of D
        for (int i = j + 1; i < N; ++i) {
            const S l = a[i][j] * a[j][j];
            for (int k = i; k < N; ++k) a[k][i] -= l * a[k][j];
            a[i][j] = l;
        }
    }
    for (int i = 0; i < N; ++i)
        for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    for (int i = N - 1; i >= 0; --i) {
        b[i] *= a[i][i];
        for (int k = i + 1; k < N; ++k) b[i] -= a[k][i] * b[k];
    }
}

/// Compute the body's shape, and the acceleration of its points while the coordinates' rates stay as they are.
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
    // Joints of a group turn by the same angle: a link's direction is that of the link before, turned by the angle.
    S angle(0);
    SinCos<S> direction{S(0), S(1)}, turn = direction;
    shape(tail.fish.links, tail.fish.link, tail.joint, tail.shape, tail.acceleration, [&](int i) {
        if (any(tail.joint[i].angle != angle)) turn = sincos(angle = tail.joint[i].angle);
        direction = {direction.sin * turn.cos + direction.cos * turn.sin,
                     direction.cos * turn.cos - direction.sin * turn.sin};
        return direction;
    });
}

/// A link's inertia about the nose, J^T Lambda J: it turns the body's twist into the link's momentum.
template <class S>
HYPERTUNA_INLINE Symmetric<S> seen_from_nose(const LinkShape<S>& at, const LinkInertia<S>& inertia) {
    const Momentum<S> u = at.wrench(inertia * Along<S>{at.c, -at.s, S(0)});
    const Momentum<S> v = at.wrench(inertia * Along<S>{at.s, at.c, S(0)});
    const Momentum<S> r = at.wrench(inertia * Along<S>{at.h_t, at.h_n, S(1)});
    return {u.x, v.x, r.x, v.y, r.y, r.z};
}

template <class S>
HYPERTUNA_INLINE S dot(const Planar<S>& a, const Planar<S>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The equations of motion M (xi', q'') = load, with the mass matrix in blocks.
template <class S, int D>
struct TailEquations {
    Symmetric<S> body;     // mass matrix of the head's twist xi
    Momentum<S> cross[D];  // mass matrix between xi and each coordinate
    S bend[D][D];          // mass matrix of the coordinates, lower triangle
    Wrench<S> load;        // load on the head
    S bend_load[D];        // load on the coordinates
};

/// Sum up the equations from nose to tail. Link i moves with xi + sum_d screw_d q'_d, so that its K = J^T Lambda J
/// appears as K, K screw and screw . K screw.
template <class S, class Law, int D>
HYPERTUNA_INLINE TailEquations<S, D> tail_equations(const Tail<S, Law, D>& tail, const Twist<S>& xi) {
    const Composite<S> unused{};  // link_load uses only the shape
    const Instant<S> now{tail.shape, tail.acceleration, unused.inertia, unused.momentum};
    TailEquations<S, D> out{};
    Twist<S> screw[D] = {};
    for (int i = 0; i < tail.fish.links; ++i) {
        const Symmetric<S> k = seen_from_nose(tail.shape[i], tail.fish.water.inertia(i));
        const Wrench<S> bias = link_load(tail.fish, now, i, xi);
        const Planar<S> joint = joint_position(tail.shape[i], tail.fish.link[i]);
        out.body = {out.body.xx + k.xx, out.body.xy + k.xy, out.body.xz + k.xz,
                    out.body.yy + k.yy, out.body.yz + k.yz, out.body.zz + k.zz};
        out.load = out.load - bias;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) {
            const S share = tail.share[i][d];
            screw[d] = screw[d] + Twist<S>{share * joint.y, -share * joint.x, share};
            const Momentum<S> carried = k * screw[d];
            out.cross[d] = out.cross[d] + carried;
            out.bend_load[d] -= dot(screw[d], bias);
            HYPERTUNA_UNROLL
            for (int e = 0; e <= d; ++e) out.bend[d][e] += dot(screw[e], carried);
        }
    }
    return out;
}

/// Accelerations under moments on the coordinates [N m], by forward dynamics. Leaves the shape in the tail's memory.
template <class S, class Law, int D>
TailAcceleration<S, D> tail_acceleration(const Tail<S, Law, D>& tail, const Bend<S, D>& bend, const Twist<S>& xi,
                                         const S (&moment)[D]) {
    constexpr int N = 3 + D;
    bend_tail(tail, bend);
    const TailEquations<S, D> sum = tail_equations(tail, xi);
    const S zero(0), one(1);
    S matrix[N][N] = {}, load[N] = {};
    matrix[0][0] = tail.clamped ? one : sum.body.xx;
    matrix[1][0] = tail.clamped ? zero : sum.body.xy;
    matrix[1][1] = tail.clamped ? one : sum.body.yy;
    matrix[2][0] = tail.clamped ? zero : sum.body.xz;
    matrix[2][1] = tail.clamped ? zero : sum.body.yz;
    matrix[2][2] = tail.clamped ? one : sum.body.zz;
    if (!tail.clamped) load[0] = sum.load.x, load[1] = sum.load.y, load[2] = sum.load.z;
    for (int d = 0; d < D; ++d) {
        if (!tail.clamped) {
            matrix[3 + d][0] = sum.cross[d].x;
            matrix[3 + d][1] = sum.cross[d].y;
            matrix[3 + d][2] = sum.cross[d].z;
        }
        for (int e = 0; e <= d; ++e) matrix[3 + d][3 + e] = sum.bend[d][e];
        matrix[3 + d][3 + d] += tail.armature[d];
        load[3 + d] = moment[d] + sum.bend_load[d];
    }
    solve_cholesky(matrix, load);
    TailAcceleration<S, D> out{{load[0], load[1], load[2]}, {}};
    for (int d = 0; d < D; ++d) out.bend[d] = load[3 + d];
    return out;
}

/// Functions that a plant calls for its body: its accelerations, the rate of its pose, and the pose without rounding
/// errors of the integrator.
template <class S, class Law, int D>
HYPERTUNA_INLINE TailAcceleration<S, D> body_acceleration(const Tail<S, Law, D>& tail, const Bend<S, D>& bend,
                                                          const Twist<S>& xi, const Pose<S>&, const S (&moment)[D]) {
    return tail_acceleration(tail, bend, xi, moment);
}
template <class S, class Law, int D>
HYPERTUNA_INLINE Pose<S> pose_rate(const Tail<S, Law, D>&, const Pose<S>& pose, const Twist<S>& xi, const S*) {
    return pose_rate(pose, xi);
}
template <class S>
HYPERTUNA_INLINE const Pose<S>& tidied(const Pose<S>& pose) {
    return pose;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
