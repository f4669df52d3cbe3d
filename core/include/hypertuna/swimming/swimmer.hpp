/// The swimmer: a body of given shape, free in the water.
///
/// Its state is the momentum P of body and entrained water in body axes, taken at the nose. With the composite
/// inertia M and the momentum b that the change of shape brings along, P = M xi + b, and Kirchhoff's equations say
///     dp/dt + r x p = F,    dl/dt + (u, v) x p = N.
/// A shape has scalars G: plain numbers where S has derivatives on which the shape does not depend.
/// This form needs no acceleration of the joints and no derivative of M: those cancel.
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S, class Law, class G = S>
struct Swimmer {
    int links;
    const Link<G>* link;
    Law water;
};

/// Inertia and shape momentum of the whole body about its nose.
template <class S>
struct Composite {
    Symmetric<S> inertia;
    Momentum<S> momentum;
};

/// One instant of a moving shape, as the swimming equations need it.
template <class S, class G = S>
struct Instant {
    const LinkShape<G>* shape;
    const LinkAcceleration<G>* acceleration;
    const Symmetric<S>& mobility;  // inverse of the composite inertia
    const Momentum<S>& momentum;   // b
};

/// M = sum J^T Lambda J and b = sum J^T Lambda a over the links.
template <class S, class Law, class G>
Composite<S> composite(const Swimmer<S, Law, G>& fish, const LinkShape<G>* shape) {
    const S zero(0);
    Composite<S> body{{zero, zero, zero, zero, zero, zero}, {zero, zero, zero}};
    for (int i = 0; i < fish.links; ++i) {
        const LinkShape<G>& at = shape[i];
        const LinkInertia<S>& inertia = fish.water.inertia(i);
        // Columns of J^T Lambda J: the momentum of this link at unit u, v and r.
        const Momentum<S> u = at.wrench(inertia * Along<G>{at.c, -at.s, G(0)});
        const Momentum<S> v = at.wrench(inertia * Along<G>{at.s, at.c, G(0)});
        const Momentum<S> r = at.wrench(inertia * Along<G>{at.h_t, at.h_n, G(1)});
        body.inertia.xx += u.x;
        body.inertia.xy += v.x;
        body.inertia.xz += r.x;
        body.inertia.yy += v.y;
        body.inertia.yz += r.y;
        body.inertia.zz += r.z;
        body.momentum = body.momentum + at.wrench(inertia * at.bending());
    }
    return body;
}

/// Velocity of the tail end of the last link.
template <class G, class V>
HYPERTUNA_INLINE Along<V> tail_velocity(const Link<G>& last, const Along<V>& v) {
    return {v.t, v.n + (last.length - last.com) * v.w, v.w};
}

/// Force of the water on link i at its velocity v, of which `bend` is the part that the change of shape makes: drag,
/// and at the tail the force of the wake that the edge sheds.
template <class S, class Law, class G, class V>
HYPERTUNA_INLINE Along<V> water_force(const Swimmer<S, Law, G>& fish, int i, const Along<V>& v, const Along<G>& bend) {
    Along<V> f;
    if constexpr (Law::beats)
        f = fish.water.drag(i, v, bend);
    else
        f = fish.water.drag(i, v);
    if constexpr (Law::sheds)
        if (i == fish.links - 1) {
            const Along<V> tail = fish.water.shed(v);
            f = {f.t + tail.t, f.n + tail.n, f.w + tail.w};
        }
    return f;
}

/// Wrench of the water on the body at twist xi.
template <class S, class Law, class G, class V>
HYPERTUNA_INLINE Wrench<V> water_wrench(const Swimmer<S, Law, G>& fish, const LinkShape<G>* shape, const Twist<V>& xi) {
    Wrench<V> sum{V(S(0)), V(S(0)), V(S(0))};
    for (int i = 0; i < fish.links; ++i)
        shape[i].add_wrench(water_force(fish, i, shape[i].velocity(xi), shape[i].bending()), sum);
    return sum;
}

template <class S, class G, class V>
HYPERTUNA_INLINE Twist<V> twist(const Instant<S, G>& now, const Momentum<V>& P) {
    return now.mobility * Momentum<V>{P.x - now.momentum.x, P.y - now.momentum.y, P.z - now.momentum.z};
}

/// The equations of swimming: rate of momentum in body axes.
template <class S, class Law, class G, class V>
HYPERTUNA_INLINE Momentum<V> momentum_rate(const Swimmer<S, Law, G>& fish, const Instant<S, G>& now,
                                           const Momentum<V>& P, const Twist<V>& xi) {
    const Wrench<V> f = water_wrench(fish, now.shape, xi);
    return {f.x + xi.z * P.y, f.y - xi.z * P.x, f.z - (xi.x * P.y - xi.y * P.x)};
}

/// Time derivative of a link's velocity J xi + a in the link's turning axes, with the twist constant: what the turning
/// of head and link adds.
template <class G, class V>
HYPERTUNA_INLINE Along<V> velocity_rate(const LinkShape<G>& at, const LinkAcceleration<G>& g, const Twist<V>& xi) {
    const V head_t = at.c * xi.x + at.s * xi.y, head_n = at.c * xi.y - at.s * xi.x;
    return {at.w * head_n + (at.w * at.h_n - at.a_n) * xi.z + g.t + at.w * at.a_n,
            (at.a_t - at.w * at.h_t) * xi.z - at.w * head_t + g.n - at.w * at.a_t, V(G(g.w))};
}

/// Load on link i that keeps the twist constant: its inertial force with added mass (Lambda dv/dt and the momentum
/// turning with the link) minus the force of the water, as a wrench at the nose.
template <class S, class Law, class G, class V>
HYPERTUNA_INLINE Wrench<V> link_load(const Swimmer<S, Law, G>& fish, const Instant<S, G>& now, int i,
                                     const Twist<V>& xi) {
    const LinkShape<G>& at = now.shape[i];
    const LinkInertia<S>& inertia = fish.water.inertia(i);
    const Along<V> v = at.velocity(xi), rate = velocity_rate(at, now.acceleration[i], xi);
    const V w = v.w;
    const Along<V> momentum = inertia * v, inertial = inertia * rate, drag = water_force(fish, i, v, at.bending());
    return at.wrench(Along<V>{inertial.t - w * momentum.n - drag.t, inertial.n + w * momentum.t - drag.n,
                              inertial.w + v.t * momentum.n - v.n * momentum.t - drag.w});
}

/// Acceleration of the nose in body axes and of the heading, d(xi)/dt: forward dynamics.
template <class S, class Law, class G, class V>
Twist<V> acceleration(const Swimmer<S, Law, G>& fish, const Instant<S, G>& now, const Twist<V>& xi) {
    const Twist<V> zero{V(S(0)), V(S(0)), V(S(0))};
    Wrench<V> load = zero;
    for (int i = 0; i < fish.links; ++i) load = load + link_load(fish, now, i, xi);
    return now.mobility * (zero - load);
}

/// Torque that each joint must give, link i - 1 on link i, counter-clockwise: inverse dynamics, tail to nose.
template <class S, class Law, class G, class V>
void joint_torques(const Swimmer<S, Law, G>& fish, const Instant<S, G>& now, const Twist<V>& xi, V* torque) {
    const Wrench<V> zero{V(S(0)), V(S(0)), V(S(0))};
    const auto moment = [&](int i, const Wrench<V>& load) {
        const Planar<G> joint = joint_position(now.shape[i], fish.link[i]);
        return load.z - (joint.x * load.y - joint.y * load.x);
    };
    Wrench<V> load = zero;
    for (int i = fish.links - 1; i >= 0; --i) {
        load = load + link_load(fish, now, i, xi);
        torque[i] = moment(i, load);
    }
    // Only the water acts on the whole body: it accelerates, and each link with it.
    const Twist<V> xi_rate = now.mobility * (zero - load);
    load = zero;
    for (int i = fish.links - 1; i >= 0; --i) {
        const LinkShape<G>& at = now.shape[i];
        load = load + at.wrench(fish.water.inertia(i) * at.along(xi_rate));
        torque[i] += moment(i, load);
    }
}

/// Kinetic energy of body and entrained water, J.
template <class S, class Law, class G, class V>
V kinetic_energy(const Swimmer<S, Law, G>& fish, const LinkShape<G>* shape, const Twist<V>& xi) {
    V twice(S(0));
    for (int i = 0; i < fish.links; ++i) {
        const Along<V> v = shape[i].velocity(xi), p = fish.water.inertia(i) * v;
        twice += v.t * p.t + v.n * p.n + v.w * p.w;
    }
    return S(base_t<S>(0.5)) * twice;
}

/// Power that the water takes out of the motion: minus the sum of force times velocity over the links.
template <class S, class Law, class G, class V>
V water_loss(const Swimmer<S, Law, G>& fish, const LinkShape<G>* shape, const Twist<V>& xi) {
    V power(S(0));
    for (int i = 0; i < fish.links; ++i) {
        const Along<V> v = shape[i].velocity(xi), f = water_force(fish, i, v, shape[i].bending());
        power -= f.t * v.t + f.n * v.n + f.w * v.w;
    }
    return power;
}

/// Power to tow the straight body at this speed, head first.
template <class S, class Law>
S towing_power(const Swimmer<S, Law>& fish, const S& speed) {
    const Along<S> v{-speed, S(0), S(0)}, still{S(0), S(0), S(0)};
    S power(0);
    for (int i = 0; i < fish.links; ++i) power -= water_force(fish, i, v, still).t * v.t;
    return power;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
