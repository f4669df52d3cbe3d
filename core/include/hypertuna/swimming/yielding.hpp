/// Joints that yield: the settled beat of a body with joints that springs and water bend.
///
/// D of the joints yield, each with an angle q from rest. All links behind joint d move with the twist
/// xi + sum_e screw_e q'_e over the joints e up to it. The state is made of momenta (P, q, p): with the mass matrix and
/// what the prescribed joints bring along, P = M xi + C q' + b and p = C^T xi + B q' + b_q, and
///     dp/dt = -k q - c q' + m(t) + N - v x pi,
/// m a moment that drives the joint, N that of the water about the joint, v the joint's velocity and pi the momentum of
/// all that hangs behind it. As for P, no derivative of the mass matrix and no acceleration of a joint is needed.
/// docs/model.md, "Joints that yield".
#pragma once

#include "hypertuna/swimming/yielding_state.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// The beat of the prescribed joints, and what lies ahead of the first joint that yields: tabulated once.
template <class S, int D>
struct YieldTable {
    const int* link;        // D: links behind the joints that yield, head to tail
    JointMotion<S>* joint;  // instants x links, the yielding ones at rest
    Composite<S>* ahead;    // instants: links ahead of the first joint that yields
    S (*moment)[D];         // instants: of what drives the joints
};

/// A swimmer with joints that yield, in its gait, as the search for its settled beat asks it.
template <class S, class Law, int D>
struct YieldingSwimmer {
    using Scalar = S;
    using State = YieldingState<S, D>;
    /// Damping by the residual loses beats that undamped steps find.
    static constexpr Retry retries[] = {
        {From::here, 0, false}, {From::rest, 10, false}, {From::rest, 40, false}, {From::rest, 160, false}};

    const Swimmer<S, Law>& fish;
    const JointShare<S>* joints;
    const ShapeTable<S>& table;  // with the springs at rest
    YieldTable<S, D> yields;
    S length, period;
    Spring<S> spring[D];
    const BeatScratch<S>& scratch;
    JointMotion<S>* joint;  // scratch, links each
    LinkShape<S>* shape;
    LinkAcceleration<S>* acceleration;
    Swinging<S, D>* swings;  // of the beat that was measured last

    /// Velocities in a state at instant k, and what hangs.
    HYPERTUNA_INLINE Moving<S, D> move(int k, const State& y, Hung<S, D>& hung) const {
        hang(k, y, hung);
        const Composite<S>& ahead = yields.ahead[k];
        Moving<S, D> out;
        out.mobility = inverse(ahead.inertia + hung.joint[0].inertia);
        Momentum<S> left = y.body - ahead.momentum - hung.joint[0].brought;
        S inertia[D][D];
        for (int d = 0; d < D; ++d) {
            const HungJoint<S>& joint = hung.joint[d];
            out.cross[d] = joint.inertia * joint.screw();
            out.carried[d] = out.mobility * out.cross[d];
            out.rate[d] = y.momentum[d] - dotted(joint.screw(), joint.brought) - dotted(out.carried[d], left);
            for (int e = 0; e <= d; ++e)
                inertia[d][e] = out.reduced[d][e] =
                    dotted(hung.joint[e].screw(), out.cross[d]) - dotted(out.carried[d], out.cross[e]);
        }
        solve_positive(inertia, out.rate);
        for (int d = 0; d < D; ++d) left = left - out.rate[d] * out.cross[d];
        out.xi = out.mobility * left;
        return out;
    }

    /// Rate of the state at instant k, with the twist of the head.
    HYPERTUNA_NOINLINE State rate(int k, const State& y, Twist<S>& xi) const {
        k = k < table.instants ? k : k - table.instants;
        Hung<S, D> hung;
        const Moving<S, D> now = move(k, y, hung);
        xi = now.xi;
        HungMotion<S> at[D];
        follow(now, hung, at);
        Wrench<S> force[D];
        for (int d = 0; d < D; ++d) {
            force[d] = {S(0), S(0), S(0)};
            for (int i = yields.link[d]; i < end(d); ++i) {
                const LinkShape<S>& link = hung.link[i - yields.link[0]];
                link.add_wrench(water_force(fish, i, link.velocity(at[d].twist), at[d].bend_of(link)), force[d]);
            }
        }
        for (int d = D - 2; d >= 0; --d) force[d] = force[d] + force[d + 1];
        Wrench<S> whole = force[0];
        const LinkShape<S>* const ahead = table.shape + k * fish.links;
        for (int i = 0; i < yields.link[0]; ++i)
            ahead[i].add_wrench(water_force(fish, i, ahead[i].velocity(xi), ahead[i].bending()), whole);
        return rate_under(k, y, now, hung, at, force, whole);
    }
    /// The same of a state with derivatives.
    template <int N>
    HYPERTUNA_NOINLINE YieldingState<Dual<S, N>, D> rate(int k, const YieldingState<Dual<S, N>, D>& y) const;

    /// State after a beat.
    template <class V>
    HYPERTUNA_NOINLINE YieldingState<V, D> swim(YieldingState<V, D> y, int stride = 1) const {
        const S step = period * S(base_t<S>(2.0 * stride / table.instants));
        for (int k = 0; k < table.instants; k += 2 * stride)
            y = runge_kutta_4(step, y, [&](int half, const YieldingState<V, D>& now) {
                if constexpr (std::same_as<V, S>) {
                    Twist<S> xi;
                    return rate(k + half * stride, now, xi);
                } else
                    return rate(k + half * stride, now);
            });
        return y;
    }

    /// The whole shape in a state at instant k, and what moves it: accelerations of the coordinates included, from the
    /// torques that springs and moments give.
    Composite<S> bend(int k, const State& y, const Moving<S, D>& now, S (&acceleration_of)[D]) const {
        Composite<S> body;
        for (int d = 0; d < D; ++d) acceleration_of[d] = S(0);
        for (int pass = 0; pass < 2; ++pass) {
            for (int i = 0; i < fish.links; ++i) joint[i] = yields.joint[k * fish.links + i];
            for (int d = 0; d < D; ++d) {
                JointMotion<S>& at = joint[yields.link[d]];
                at.angle += y.angle[d], at.rate += now.rate[d], at.acceleration += acceleration_of[d];
            }
            hypertuna::shape(fish.links, fish.link, joint, shape, acceleration);
            if (pass) break;
            body = composite(fish, shape);
            const Symmetric<S> mobility = inverse(body.inertia);
            joint_torques(fish, Instant<S>{shape, acceleration, mobility, body.momentum}, now.xi, scratch.torque);
            S inertia[D][D];
            for (int d = 0; d < D; ++d) {
                acceleration_of[d] =
                    spring[d].passive(y.angle[d], now.rate[d]) + yields.moment[k][d] - scratch.torque[yields.link[d]];
                for (int e = 0; e <= d; ++e) inertia[d][e] = now.reduced[d][e];
            }
            solve_positive(inertia, acceleration_of);
        }
        return body;
    }

    /// The beat from a state, measured.
    Beat<S, State> measure(const State& start) const;
    /// Twist of the head at the beat's start.
    Twist<S> head(const State& y) const {
        Hung<S, D> hung;
        return move(0, y, hung).xi;
    }

    /// A change of the state as a change of the motion at the beat's start, with the springs at rest, and back.
    State motion(const State& change) const {
        Hung<S, D> hung;
        const State still = filled<State>(S(0));
        State moved = change;
        for (int d = 0; d < D; ++d) moved.angle[d] = S(0);
        const Moving<S, D> with = move(0, moved, hung), without = move(0, still, hung);
        State out{with.xi - without.xi, {}, {}};
        for (int d = 0; d < D; ++d) out.angle[d] = change.angle[d], out.momentum[d] = with.rate[d] - without.rate[d];
        return out;
    }
    State state(const State& change) const {
        Hung<S, D> hung;
        hang(0, filled<State>(S(0)), hung);
        State out{yields.ahead[0].inertia * change.body, {}, {}};
        Twist<S> twist = change.body;
        Momentum<S> further{S(0), S(0), S(0)};
        for (int d = 0; d < D; ++d) {
            twist = twist + change.momentum[d] * hung.joint[d].screw();
            out.angle[d] = change.angle[d];
        }
        for (int d = D - 1; d >= 0; --d) {
            const HungJoint<S>& joint = hung.joint[d];
            const Momentum<S> behind = joint.inertia * twist + further, turned = change.momentum[d] * joint.screw();
            out.momentum[d] = dotted(joint.screw(), behind);
            further = further + joint.inertia * turned, twist = twist - turned;
            if (d == 0) out.body = out.body + behind;
        }
        return out;
    }
    /// Of a change of the motion: of the body's as for a swimmer, angles in rad, rates in rad each rad of the beat.
    S size(const State& d) const {
        S most = period * max(max(abs(d.body.x), abs(d.body.y)) / length, abs(d.body.z));
        for (int k = 0; k < D; ++k)
            most = max(most, max(abs(d.angle[k]), S(base_t<S>(0.5 / pi)) * period * abs(d.momentum[k])));
        return most;
    }
    S stride(const State& y) const { return period * abs(surge(y)) / length + S(base_t<S>(1e-3)); }
    /// A step from a state taken in u |u|, as a swimmer's; the speed also changes with the angles that the step
    /// changes.
    State step_in_square(State d, const State& y) const;

  private:
    int end(int d) const { return d + 1 < D ? yields.link[d + 1] : fish.links; }
    S surge(const State& y) const { return head(y).x; }
    /// How the joints move that yield.
    HYPERTUNA_INLINE void follow(const Moving<S, D>& now, const Hung<S, D>& hung, HungMotion<S> (&at)[D]) const {
        Twist<S> yielding{S(0), S(0), S(0)};
        for (int d = 0; d < D; ++d) {
            const HungJoint<S>& joint = hung.joint[d];
            at[d].bend_x = yielding.x - yielding.z * joint.y + joint.v_x;
            at[d].bend_y = yielding.y + yielding.z * joint.x + joint.v_y;
            at[d].v_x = at[d].bend_x + now.xi.x - now.xi.z * joint.y;
            at[d].v_y = at[d].bend_y + now.xi.y + now.xi.z * joint.x;
            yielding = yielding + now.rate[d] * joint.screw();
            at[d].yielding = yielding, at[d].twist = now.xi + yielding;
        }
        Momentum<S> further{S(0), S(0), S(0)};  // what joints further back add to the momentum
        for (int d = D - 1; d >= 0; --d) {
            at[d].momentum = hung.joint[d].inertia * at[d].twist + hung.joint[d].brought + further;
            further = further + now.rate[d] * now.cross[d];
        }
    }
    /// Rate of the state under the force of the water on all that hangs behind each joint, and on the whole body.
    HYPERTUNA_INLINE State rate_under(int k, const State& y, const Moving<S, D>& now, const Hung<S, D>& hung,
                                      const HungMotion<S> (&at)[D], const Wrench<S> (&force)[D],
                                      const Wrench<S>& whole) const {
        State out;
        for (int d = 0; d < D; ++d) {
            out.angle[d] = now.rate[d];
            out.momentum[d] = spring[d].passive(y.angle[d], now.rate[d]) + yields.moment[k][d] +
                              dotted(hung.joint[d].screw(), force[d]) -
                              (at[d].v_x * at[d].momentum.y - at[d].v_y * at[d].momentum.x);
        }
        const Momentum<S>& P = y.body;
        const Twist<S>& xi = now.xi;
        out.body = {whole.x + xi.z * P.y, whole.y - xi.z * P.x, whole.z - (xi.x * P.y - xi.y * P.x)};
        return out;
    }
    /// The links that hang and the joints that yield in a state at instant k.
    HYPERTUNA_INLINE void hang(int k, const State& y, Hung<S, D>& hung) const {
        const int first = yields.link[0];
        const LinkShape<S>& last = table.shape[k * fish.links + first - 1];
        const Link<S>& ahead = fish.link[first - 1];
        const S along = last.h_n - ahead.com + ahead.length, v_n = last.a_n + (ahead.length - ahead.com) * last.w;
        S x = last.c * along + last.s * last.h_t, y_at = last.s * along - last.c * last.h_t;  // end of the link ahead
        S v_x = last.c * last.a_t - last.s * v_n, v_y = last.s * last.a_t + last.c * v_n;
        S c = last.c, s = last.s, w = last.w;
        for (int d = 0; d < D; ++d) {
            Composite<S> behind{};
            hung.joint[d].x = x, hung.joint[d].y = y_at, hung.joint[d].v_x = v_x, hung.joint[d].v_y = v_y;
            for (int i = yields.link[d]; i < end(d); ++i) {
                const JointMotion<S>& prescribed = yields.joint[k * fish.links + i];
                const auto [sine, cosine] =
                    sincos(i == yields.link[d] ? prescribed.angle + y.angle[d] : prescribed.angle);
                const S before = s;
                s = s * cosine + c * sine, c = c * cosine - before * sine;
                w += prescribed.rate;
                const S com = fish.link[i].com, l = fish.link[i].length;
                LinkShape<S>& link = hung.link[i - first];
                link = {c, s, x * s - y_at * c, x * c + y_at * s + com, c * v_x + s * v_y, c * v_y - s * v_x + com * w,
                        w};
                const LinkInertia<S>& inertia = fish.water.inertia(i);
                const Momentum<S> u = link.wrench(inertia * Along<S>{c, -s, S(0)});
                const Momentum<S> v = link.wrench(inertia * Along<S>{s, c, S(0)});
                const Momentum<S> r = link.wrench(inertia * Along<S>{link.h_t, link.h_n, S(1)});
                behind.inertia = behind.inertia + Symmetric<S>{u.x, v.x, r.x, v.y, r.y, r.z};
                behind.momentum = behind.momentum + link.wrench(inertia * link.bending());
                x += l * c, y_at += l * s;
                v_x -= l * w * s, v_y += l * w * c;
            }
            hung.joint[d].inertia = behind.inertia, hung.joint[d].brought = behind.momentum;
        }
        for (int d = D - 2; d >= 0; --d) {
            hung.joint[d].inertia = hung.joint[d].inertia + hung.joint[d + 1].inertia;
            hung.joint[d].brought = hung.joint[d].brought + hung.joint[d + 1].brought;
        }
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
