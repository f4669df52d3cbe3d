/// Derivatives of the equations of joints that yield, link by link: what depends on D angles and on the velocities is
/// not carried through every operation as derivatives by the whole state.
///
/// A change of q_e turns all that hangs behind joint e about it. Seen from there, only the joint's velocity v_e turns,
/// the other way: the links' own velocities change as by the twist (v_e,y, -v_e,x, 0).
#pragma once

#include "hypertuna/swimming/yielding.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A 3 x 3 matrix by its columns: how a wrench changes with a twist.
template <class S>
struct Slope {
    Wrench<S> x, y, z;

    friend HYPERTUNA_INLINE Slope operator+(const Slope& a, const Slope& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend HYPERTUNA_INLINE Wrench<S> operator*(const Slope& a, const Twist<S>& b) {
        return b.x * a.x + b.y * a.y + b.z * a.z;
    }
    friend HYPERTUNA_INLINE Planar<S> dotted(const Planar<S>& a, const Slope& b) {
        return {dotted(a, b.x), dotted(a, b.y), dotted(a, b.z)};
    }
};

/// Force of the water on links, and its slopes with their twist and with the part of it that the change of shape makes.
template <class S>
struct WaterSlopes {
    Wrench<S> force;
    Slope<S> twist, bend;

    friend HYPERTUNA_INLINE WaterSlopes operator+(const WaterSlopes& a, const WaterSlopes& b) {
        return {a.force + b.force, a.twist + b.twist, a.bend + b.bend};
    }
    /// Add link i at its velocity v, with the slope with its part `bend` if `bends`.
    template <bool bends, class Law>
    HYPERTUNA_INLINE void add(const Swimmer<S, Law>& fish, int i, const LinkShape<S>& at, const Along<S>& v,
                              const Along<S>& bend) {
        using V = Dual<S, bends ? 5 : 3>;
        Along<V> moving{V(v.t), V(v.n), V(v.w)};
        moving.t.d[0] = moving.n.d[1] = moving.w.d[2] = S(1);
        Along<V> f;
        if constexpr (bends) {
            Along<V> bending{V(bend.t), V(bend.n), V(bend.w)};
            bending.n.d[3] = bending.w.d[4] = S(1);
            f = water_force(Swimmer<S, Law, V>{fish.links, nullptr, fish.water}, i, moving, bending);
        } else
            f = water_force(fish, i, moving, bend);
        at.add_wrench(Along<S>{f.t.v, f.n.v, f.w.v}, force);
        const auto slope = [&](int k) { return at.wrench(Along<S>{f.t.d[k], f.n.d[k], f.w.d[k]}); };
        const Wrench<S> t = slope(0), n = slope(1);
        twist = twist + Slope<S>{at.c * t + -at.s * n, at.s * t + at.c * n, at.h_t * t + at.h_n * n + slope(2)};
        if constexpr (bends) {
            const Wrench<S> bent = slope(3);
            this->bend = this->bend + Slope<S>{-at.s * bent, at.c * bent, at.h_n * bent + slope(4)};
        }
    }
};

/// How twist and rates change with the state.
template <class S, int D>
struct VelocityChanges {
    const Moving<S, D>& now;
    Momentum<S> turned[D];  // change of the body's momentum with each angle while the body moves on as it does,
    S turned_joint[D][D];   // and of each joint's momentum
    S inverse[D][D];        // of `now.reduced`

    HYPERTUNA_INLINE VelocityChanges(const Moving<S, D>& moving, const Hung<S, D>& hung, const HungMotion<S> (&at)[D])
        : now(moving) {
        for (int e = 0; e < D; ++e) {
            const HungJoint<S>& joint = hung.joint[e];
            turned[e] = joint.turn(at[e].momentum) + joint.inertia * at[e].turning();
            S inertia[D][D], column[D];
            for (int d = 0; d < D; ++d) {
                const Momentum<S> own = e <= d ? hung.joint[d].inertia * at[e].turning() : turned[e];
                turned_joint[d][e] = dotted(hung.joint[d].screw(), own);
                column[d] = S(d == e ? 1 : 0);
                for (int i = 0; i <= d; ++i) inertia[d][i] = now.reduced[d][i];
            }
            solve_positive(inertia, column);
            for (int d = 0; d < D; ++d) inverse[d][e] = column[d];
        }
    }
    /// Changes of twist and rates with a change of the state.
    HYPERTUNA_INLINE void of(const YieldingState<S, D>& change, Twist<S>& xi, S (&rate)[D]) const {
        Momentum<S> body = change.body;
        S own[D];
        for (int e = 0; e < D; ++e) body = body - change.angle[e] * turned[e];
        for (int d = 0; d < D; ++d) {
            own[d] = change.momentum[d] - dotted(now.carried[d], body);
            for (int e = 0; e < D; ++e) own[d] -= turned_joint[d][e] * change.angle[e];
        }
        xi = now.mobility * body;
        for (int d = 0; d < D; ++d) {
            rate[d] = S(0);
            for (int e = 0; e < D; ++e) rate[d] += inverse[d][e] * own[e];
            xi = xi - rate[d] * now.carried[d];
        }
    }
};

/// How the rate of the momenta changes with twist, rates and angles.
template <class S, int D>
struct ForceChanges {
    Slope<S> twist;               // the body's momentum with the twist,
    Wrench<S> rate[D], angle[D];  // with each rate and each angle;
    Planar<S> joint_twist[D];     // each joint's momentum with the twist, with each rate and each angle
    S joint_rate[D][D], joint_angle[D][D];

    /// From forces on links behind each joint and on all, and the momentum P.
    HYPERTUNA_INLINE ForceChanges(const Hung<S, D>& hung, const HungMotion<S> (&at)[D], const Moving<S, D>& now,
                                  const VelocityChanges<S, D>& velocity, const WaterSlopes<S> (&water)[D],
                                  const Slope<S>& whole, const Momentum<S>& P)
        : twist(whole + Slope<S>{{S(0), S(0), -P.y}, {S(0), S(0), P.x}, {P.y, -P.x, S(0)}}) {
        for (int e = 0; e < D; ++e) {
            const HungJoint<S>& joint = hung.joint[e];
            rate[e] = water[e].twist * joint.screw() + water[e].bend * joint.screw();
            angle[e] = joint.turn(water[e].force) + water[e].twist * at[e].turning() + water[e].bend * at[e].bending();
        }
        for (int d = 0; d < D; ++d) {
            const HungJoint<S>& joint = hung.joint[d];
            const Symmetric<S>& K = joint.inertia;
            const Momentum<S>& pi = at[d].momentum;
            const S &v_x = at[d].v_x, &v_y = at[d].v_y;
            // v x pi with the twist: by the joint's velocity v, and by the momentum pi
            const Planar<S> held{pi.y, -pi.x, -(joint.y * pi.y + joint.x * pi.x)},
                pushed{v_x * K.xy - v_y * K.xx, v_x * K.yy - v_y * K.xy, v_x * K.yz - v_y * K.xz};
            joint_twist[d] = dotted(joint.screw(), water[d].twist) - held - pushed;
            const Planar<S> bend = dotted(joint.screw(), water[d].bend);
            for (int e = 0; e < D; ++e)
                if (e <= d) {
                    const Twist<S> screw = hung.joint[e].screw();
                    joint_rate[d][e] = dotted(joint_twist[d], screw) + dotted(bend, screw);
                    joint_angle[d][e] = dotted(joint_twist[d], at[e].turning()) + dotted(bend, at[e].bending());
                } else {
                    const Momentum<S>&by_rate = now.cross[e], &by_angle = velocity.turned[e];
                    joint_rate[d][e] = dotted(joint.screw(), rate[e]) - (v_x * by_rate.y - v_y * by_rate.x);
                    joint_angle[d][e] = dotted(joint.screw(), angle[e]) - (v_x * by_angle.y - v_y * by_angle.x);
                }
        }
    }
};

template <class S, class Law, int D>
template <int N>
YieldingState<Dual<S, N>, D> YieldingSwimmer<S, Law, D>::rate(int k, const YieldingState<Dual<S, N>, D>& with) const {
    k = k < table.instants ? k : k - table.instants;
    State y;
    for (int i = 0; i < State::size; ++i) component(y, i) = component(with, i).v;
    Hung<S, D> hung;
    HungMotion<S> at[D];
    const Moving<S, D> now = move(k, y, hung);
    follow(now, hung, at);
    WaterSlopes<S> water[D]{}, whole{};
    for (int d = 0; d < D; ++d)
        for (int i = yields.link[d]; i < end(d); ++i) {
            const LinkShape<S>& link = hung.link[i - yields.link[0]];
            water[d].template add<Law::beats>(fish, i, link, link.velocity(at[d].twist), at[d].bend_of(link));
        }
    for (int d = D - 2; d >= 0; --d) water[d] = water[d] + water[d + 1];
    const LinkShape<S>* const ahead = table.shape + k * fish.links;
    for (int i = 0; i < yields.link[0]; ++i)
        whole.template add<false>(fish, i, ahead[i], ahead[i].velocity(now.xi), ahead[i].bending());
    whole = whole + water[0];
    Wrench<S> force[D];
    for (int d = 0; d < D; ++d) force[d] = water[d].force;
    const State value = rate_under(k, y, now, hung, at, force, whole.force);
    const VelocityChanges<S, D> velocity(now, hung, at);
    ForceChanges<S, D> change(hung, at, now, velocity, water, whole.twist, y.body);
    for (int d = 0; d < D; ++d) {
        Dual<S, 2> angle(y.angle[d]), turning(now.rate[d]);
        angle.d[0] = turning.d[1] = S(1);
        const Dual<S, 2> moment = spring[d].passive(angle, turning);
        change.joint_angle[d][d] += moment.d[0], change.joint_rate[d][d] += moment.d[1];
    }
    YieldingState<Dual<S, N>, D> out;
    for (int i = 0; i < State::size; ++i) component(out, i).v = component(value, i);
    for (int n = 0; n < N; ++n) {
        State step;
        for (int i = 0; i < State::size; ++i) component(step, i) = component(with, i).d[n];
        Twist<S> xi;
        S rate[D];
        velocity.of(step, xi, rate);
        Wrench<S> body = change.twist * xi;
        for (int e = 0; e < D; ++e) body = body + rate[e] * change.rate[e] + step.angle[e] * change.angle[e];
        const Momentum<S>& P = step.body;
        out.body.x.d[n] = body.x + now.xi.z * P.y;
        out.body.y.d[n] = body.y - now.xi.z * P.x;
        out.body.z.d[n] = body.z - (now.xi.x * P.y - now.xi.y * P.x);
        for (int d = 0; d < D; ++d) {
            S moment = dotted(change.joint_twist[d], xi);
            for (int e = 0; e < D; ++e)
                moment += change.joint_rate[d][e] * rate[e] + change.joint_angle[d][e] * step.angle[e];
            out.angle[d].d[n] = rate[d], out.momentum[d].d[n] = moment;
        }
    }
    return out;
}

template <class S, class Law, int D>
YieldingState<S, D> YieldingSwimmer<S, Law, D>::step_in_square(State d, const State& y) const {
    Hung<S, D> hung;
    HungMotion<S> at[D];
    const Moving<S, D> now = move(0, y, hung);
    follow(now, hung, at);
    Twist<S> changed;
    S rate[D];
    VelocityChanges<S, D>(now, hung, at).of(state(d), changed, rate);
    const S &u = now.xi.x, &more = changed.x, square = u * u + (u + u) * more;
    const S root = sqrt(max(square, S(0)));
    d.body.x += select(S(0) < square, select(u < S(0), -root, root) - u, more) - more;
    return d;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
