/// Joints that yield: the settled beat of a body with joints that springs and water bend.
///
/// D coordinates of these joints come beside the prescribed ones. The joint in front of link i yields by share[i] . q,
/// so that link i moves with the twist xi + sum_d screw_id q'_d. The state is made of momenta (P, q, p): with the mass
/// matrix and what the prescribed joints bring along, P = M xi + C q' + b and p = C^T xi + B q' + b_q, and
///     dp/dt = -k q - c q' + m(t) + N - v x pi,
/// m a moment that drives the joint, N that of the water about the joint, v the joint's velocity and pi the momentum of
/// all that hangs behind it. As for P, no derivative of the mass matrix and no acceleration of a joint is needed.
/// docs/model.md, "Joints that yield".
#pragma once

#include "hypertuna/swimming/yielding_state.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int max_hung = 32;  // links from the first joint that yields to the tail

/// The beat of the prescribed joints, and what lies ahead of the first joint that yields: tabulated once.
template <class S, int D>
struct YieldTable {
    int first;                    // link behind the first joint that yields
    const base_t<S> (*share)[D];  // part of each coordinate that a link's front joint takes
    JointMotion<S>* joint;        // instants x links, the yielding ones at rest
    Composite<S>* ahead;          // instants: links before `first`
    S (*moment)[D];               // instants: of what drives the coordinates
};

/// A swimmer with joints that yield, in its gait, as the search for its settled beat asks it.
template <class S, class Law, int D>
struct YieldingSwimmer {
    using Scalar = S;
    using State = YieldingState<S, D>;
    template <class V>
    using Hanging = Hung<Shaped<S, V, D>, D>;
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

    /// Velocities in a state at instant k, and the links that hang.
    template <class V>
    HYPERTUNA_INLINE Moving<V, D> move(int k, const YieldingState<V, D>& y, Hanging<V>* hung) const {
        using G = Shaped<S, V, D>;
        const int first = yields.first;
        G angles[D];
        for (int d = 0; d < D; ++d) {
            if constexpr (std::same_as<G, V>)
                angles[d] = y.angle[d];
            else
                angles[d] = G(y.angle[d].v), angles[d].d[d] = S(1);
        }
        const G none(S(0));
        Hung<G, D> at = joint_behind<G>(k);
        SinCos<G> direction{G(table.shape[k * fish.links + first - 1].s), G(table.shape[k * fish.links + first - 1].c)};
        S w = table.shape[k * fish.links + first - 1].w;
        const Symmetric<S>& ahead = yields.ahead[k].inertia;
        Symmetric<G> body{G(ahead.xx), G(ahead.xy), G(ahead.xz), G(ahead.yy), G(ahead.yz), G(ahead.zz)};
        Momentum<G> brought = widen<G>(yields.ahead[k].momentum), cross[D];
        G bend[D][D], bend_brought[D];
        for (int d = 0; d < D; ++d) {
            cross[d] = {none, none, none}, bend_brought[d] = none;
            for (int e = 0; e <= d; ++e) bend[d][e] = none;
        }
        for (int i = first; i < fish.links; ++i) {
            const JointMotion<S>& prescribed = yields.joint[k * fish.links + i];
            G angle(prescribed.angle);
            for (int d = 0; d < D; ++d) angle += S(yields.share[i][d]) * angles[d];
            const SinCos<G> turn = sincos(angle);
            direction = {direction.sin * turn.cos + direction.cos * turn.sin,
                         direction.cos * turn.cos - direction.sin * turn.sin};
            w += prescribed.rate;
            hang(i, direction, w, at);
            hung[i - first] = at;
            const LinkInertia<S>& inertia = fish.water.inertia(i);
            const Momentum<G> u = at.at.wrench(inertia * Along<G>{at.at.c, -at.at.s, none});
            const Momentum<G> v = at.at.wrench(inertia * Along<G>{at.at.s, at.at.c, none});
            const Momentum<G> r = at.at.wrench(inertia * Along<G>{at.at.h_t, at.at.h_n, G(S(1))});
            const Momentum<G> own_brought = at.at.wrench(inertia * at.at.bending());
            const Symmetric<G> own{u.x, v.x, r.x, v.y, r.y, r.z};
            body = {body.xx + u.x, body.xy + v.x, body.xz + r.x, body.yy + v.y, body.yz + r.y, body.zz + r.z};
            brought = brought + own_brought;
            for (int d = 0; d < D; ++d) {
                const Momentum<G> carried = own * at.screw[d];
                cross[d] = cross[d] + carried;
                bend_brought[d] += dotted(at.screw[d], own_brought);
                for (int e = 0; e <= d; ++e) bend[d][e] += dotted(at.screw[e], carried);
            }
            const S l = fish.link[i].length;
            at.x += l * direction.cos, at.y += l * direction.sin;
            at.v_x -= l * w * direction.sin, at.v_y += l * w * direction.cos;
        }
        const Symmetric<G> mobility = inverse(body);
        Momentum<V> left = y.body - lifted(brought, y.angle);
        Moving<V, D> out;
        V inertia[D][D];
        for (int d = 0; d < D; ++d) {
            const Twist<G> moved = mobility * cross[d];
            out.rate[d] = y.momentum[d] - lifted(bend_brought[d], y.angle) - dotted(lifted(moved, y.angle), left);
            for (int e = 0; e <= d; ++e)
                inertia[d][e] = out.reduced[d][e] = lifted(bend[d][e] - dotted(moved, cross[e]), y.angle);
        }
        solve_positive(inertia, out.rate);
        for (int d = 0; d < D; ++d) left = left - out.rate[d] * lifted(cross[d], y.angle);
        const Symmetric<V> free{lifted(mobility.xx, y.angle), lifted(mobility.xy, y.angle),
                                lifted(mobility.xz, y.angle), lifted(mobility.yy, y.angle),
                                lifted(mobility.yz, y.angle), lifted(mobility.zz, y.angle)};
        out.xi = free * left;
        return out;
    }

    /// Rate of the state at instant k, with the twist of the head.
    template <class V>
    HYPERTUNA_NOINLINE YieldingState<V, D> rate(int k, const YieldingState<V, D>& y, Twist<V>& xi) const {
        k = k < table.instants ? k : k - table.instants;
        Hanging<V> hung[max_hung];
        const Moving<V, D> now = move(k, y, hung);
        xi = now.xi;
        YieldingState<V, D> out;
        for (int d = 0; d < D; ++d) {
            out.angle[d] = now.rate[d];
            out.momentum[d] = spring[d].passive(y.angle[d], now.rate[d]) + yields.moment[k][d];
        }
        const V none(S(0));
        Wrench<V> force{none, none, none};
        Momentum<V> behind = force;
        const Swimmer<S, Law, V> tail{fish.links, nullptr, fish.water};
        for (int i = fish.links - 1; i >= yields.first; --i) {
            const Hung<V, D> link = lifted_link(hung[i - yields.first], y.angle);
            Twist<V> yielding{none, none, none};
            for (int d = 0; d < D; ++d) yielding = yielding + now.rate[d] * link.screw[d];
            const Twist<V> twist = xi + yielding;
            const Along<V> v = link.at.velocity(twist), a = link.at.bending(), more = link.at.along(yielding);
            const Along<V> bend{a.t + more.t, a.n + more.n, a.w + more.w};
            link.at.add_wrench(water_force(tail, i, v, bend), force);
            behind = behind + link.at.wrench(fish.water.inertia(i) * v);
            const V v_x = twist.x - twist.z * link.y + link.v_x, v_y = twist.y + twist.z * link.x + link.v_y;
            const V moment = force.z - (link.x * force.y - link.y * force.x) - (v_x * behind.y - v_y * behind.x);
            for (int d = 0; d < D; ++d)
                if (yields.share[i][d] != 0) out.momentum[d] += S(yields.share[i][d]) * moment;
        }
        const LinkShape<S>* const at = table.shape + k * fish.links;
        for (int i = yields.first - 1; i >= 0; --i)
            at[i].add_wrench(water_force(fish, i, at[i].velocity(xi), at[i].bending()), force);
        const Momentum<V>& P = y.body;
        out.body = {force.x + xi.z * P.y, force.y - xi.z * P.x, force.z - (xi.x * P.y - xi.y * P.x)};
        return out;
    }

    /// State after a beat.
    template <class V>
    HYPERTUNA_NOINLINE YieldingState<V, D> swim(YieldingState<V, D> y, int stride = 1) const {
        const S step = period * S(base_t<S>(2.0 * stride / table.instants));
        for (int k = 0; k < table.instants; k += 2 * stride)
            y = runge_kutta_4(step, y, [&](int half, const YieldingState<V, D>& now) {
                Twist<V> xi;
                return rate(k + half * stride, now, xi);
            });
        return y;
    }

    /// The whole shape in a state at instant k, and what moves it: accelerations of the coordinates included, from the
    /// torques that springs and moments give.
    Composite<S> bend(int k, const State& y, const Moving<S, D>& now, S (&acceleration_of)[D]) const {
        Composite<S> body;
        for (int pass = 0; pass < 2; ++pass) {
            for (int i = 0; i < fish.links; ++i) {
                joint[i] = yields.joint[k * fish.links + i];
                for (int d = 0; d < D; ++d) {
                    const S share(yields.share[i][d]);
                    joint[i].angle += share * y.angle[d], joint[i].rate += share * now.rate[d];
                    if (pass) joint[i].acceleration += share * acceleration_of[d];
                }
            }
            hypertuna::shape(fish.links, fish.link, joint, shape, acceleration);
            if (pass) break;
            body = composite(fish, shape);
            const Symmetric<S> mobility = inverse(body.inertia);
            joint_torques(fish, Instant<S>{shape, acceleration, mobility, body.momentum}, now.xi, scratch.torque);
            S inertia[D][D];
            for (int d = 0; d < D; ++d) {
                acceleration_of[d] = spring[d].passive(y.angle[d], now.rate[d]) + yields.moment[k][d];
                for (int i = yields.first; i < fish.links; ++i)
                    acceleration_of[d] -= S(yields.share[i][d]) * scratch.torque[i];
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
        Hung<S, D> hung[max_hung];
        return move(0, y, hung).xi;
    }

    /// A change of the state as a change of the motion at the beat's start, with the springs at rest, and back.
    State motion(const State& change) const {
        Hung<S, D> hung[max_hung];
        const State still = filled<State>(S(0));
        State moved = change;
        for (int d = 0; d < D; ++d) moved.angle[d] = S(0);
        const Moving<S, D> with = move(0, moved, hung), without = move(0, still, hung);
        State out{with.xi - without.xi, {}, {}};
        for (int d = 0; d < D; ++d) out.angle[d] = change.angle[d], out.momentum[d] = with.rate[d] - without.rate[d];
        return out;
    }
    State state(const State& change) const {
        Hung<S, D> hung[max_hung];
        move(0, filled<State>(S(0)), hung);
        State out = change;
        out.body = yields.ahead[0].inertia * change.body;
        for (int d = 0; d < D; ++d) out.momentum[d] = S(0);
        for (int i = yields.first; i < fish.links; ++i) {
            const Hung<S, D>& link = hung[i - yields.first];
            Twist<S> twist = change.body;
            for (int d = 0; d < D; ++d) twist = twist + change.momentum[d] * link.screw[d];
            const Momentum<S> own = link.at.wrench(fish.water.inertia(i) * link.at.along(twist));
            out.body = out.body + own;
            for (int d = 0; d < D; ++d) out.momentum[d] += dotted(link.screw[d], own);
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
    State step_in_square(State d, const State& y) const {
        State step = state(d);
        YieldingState<Dual<S, 1>, D> along = widen<Dual<S, 1>>(y);
        for (int k = 0; k < State::size; ++k) component(along, k).d[0] = component(step, k);
        const Dual<S, 1> speed = surge(along);
        const S &u = speed.v, &more = speed.d[0], square = u * u + (u + u) * more;
        const S root = sqrt(max(square, S(0)));
        d.body.x += select(S(0) < square, select(u < S(0), -root, root) - u, more) - more;
        return d;
    }

  private:
    template <class V>
    V surge(const YieldingState<V, D>& y) const {
        Hanging<V> hung[max_hung];
        return move(0, y, hung).xi.x;
    }
    /// The end of the links ahead at instant k.
    template <class G>
    HYPERTUNA_INLINE Hung<G, D> joint_behind(int k) const {
        const LinkShape<S>& last = table.shape[k * fish.links + yields.first - 1];
        const Link<S>& link = fish.link[yields.first - 1];
        const S along = last.h_n - link.com + link.length, v_n = last.a_n + (link.length - link.com) * last.w;
        Hung<G, D> at{};
        at.x = G(last.c * along + last.s * last.h_t), at.y = G(last.s * along - last.c * last.h_t);
        at.v_x = G(last.c * last.a_t - last.s * v_n), at.v_y = G(last.s * last.a_t + last.c * v_n);
        for (int d = 0; d < D; ++d) at.screw[d] = {G(S(0)), G(S(0)), G(S(0))};
        return at;
    }
    template <class V, class G>
    static HYPERTUNA_INLINE Hung<V, D> lifted_link(const Hung<G, D>& link, const V (&angle)[D]) {
        const auto up = [&](const G& x) { return lifted(x, angle); };
        const LinkShape<G>& at = link.at;
        Hung<V, D> out{{up(at.c), up(at.s), up(at.h_t), up(at.h_n), up(at.a_t), up(at.a_n), V(S(0))},
                       up(link.x),
                       up(link.y),
                       up(link.v_x),
                       up(link.v_y),
                       {}};
        if constexpr (std::same_as<G, V>)
            out.at.w = at.w;
        else
            out.at.w = V(at.w.v);
        for (int d = 0; d < D; ++d) out.screw[d] = lifted(link.screw[d], angle);
        return out;
    }
    /// Shape of link i behind the joint in `at`, and its screws.
    template <class V>
    HYPERTUNA_INLINE void hang(int i, const SinCos<V>& direction, const S& w, Hung<V, D>& at) const {
        const V &c = direction.cos, &s = direction.sin;
        const S com = fish.link[i].com;
        at.at = {c,
                 s,
                 at.x * s - at.y * c,
                 at.x * c + at.y * s + com,
                 c * at.v_x + s * at.v_y,
                 c * at.v_y - s * at.v_x + com * w,
                 V(w)};
        for (int d = 0; d < D; ++d) {
            const S share(yields.share[i][d]);
            at.screw[d] = at.screw[d] + Twist<V>{share * at.y, -(share * at.x), V(share)};
        }
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
