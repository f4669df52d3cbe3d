/// Water: what it adds to a link's inertia and the drag it exerts.
///
/// A water law is a type with
///     LinkInertia<S> inertia(i)          the link's inertia with its added mass
///     Along<V> drag(i, Along<V> v)       force along and across link i and moment about its center of mass
///     Along<V> shed(Along<V> v)          force at the tail end of the last link, at the velocity there
/// Velocities are relative to the water. A uniform current only carries the frame along (physics is the same
/// in every inertial frame), so it appears where positions are reported and nowhere here.
#pragma once

#include "hypertuna/swimming/chain.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Inertia of a link in its own axes at its center of mass: kinetic energy is
/// 1/2 (tangential v_t^2 + normal v_n^2 + 2 coupling v_n w + rotary w^2).
template <class S>
struct LinkInertia {
    S tangential, normal;  // kg
    S coupling;            // kg m
    S rotary;              // kg m^2

    template <class V>
    HYPERTUNA_INLINE Along<product_t<S, V>> operator*(const Along<V>& v) const {
        return {tangential * v.t, normal * v.n + coupling * v.w, coupling * v.n + rotary * v.w};
    }
};

/// The paper's law (Eqs 33-35): added mass alike in all directions, quadratic drag at the center of mass.
template <class S>
struct Lumped {
    struct Coefficients {
        S inertia_mass;  // m (1 + c_m), kg
        S inertia;       // kg m^2
        S friction;      // 1/2 rho c_f S, kg/m
        S drag;          // 1/2 rho c_d S, kg/m
    };
    const Coefficients* links;

    static constexpr bool sheds = false;

    HYPERTUNA_INLINE LinkInertia<S> inertia(int i) const {
        return {links[i].inertia_mass, links[i].inertia_mass, S(0), links[i].inertia};
    }
    template <class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v) const {
        return {-(links[i].friction * times_abs(v.t)), -(links[i].drag * times_abs(v.n)), V(S(0))};
    }
};

/// Slender-body strips: added mass and drag per length, integrated along every link.
template <class S>
struct Strip {
    struct Coefficients {
        LinkInertia<S> inertia;       // with added mass
        S friction, linear_friction;  // along the whole link: kg/m, kg/s
        S drag, linear_drag;          // across it, whole link: kg/m, kg/s
        S middle, half_length;        // of the link, from its center of mass, m
    };
    const Coefficients* links;
    S shedding;       // kg/m: coefficient times added mass per length at the trailing edge
    bool cross_flow;  // normal drag as v_n |v| instead of v_n |v_n|

    static constexpr bool sheds = true;
    // Gauss-Legendre on [-1, 1], symmetric: position and weight (halved, so that they add up to 1).
    static constexpr int pairs = 2;
    static constexpr double node[pairs] = {0.33998104358485626, 0.86113631159405258};
    static constexpr double weight[pairs] = {0.32607257743127307, 0.17392742256872693};

    // By reference: a copy takes longer than what is done with it.
    HYPERTUNA_INLINE const LinkInertia<S>& inertia(int i) const { return links[i].inertia; }

    template <class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v) const {
        const Coefficients& k = links[i];
        Along<V> f = {-(k.friction * times_abs(v.t) + k.linear_friction * v.t), V(S(0)), V(S(0))};
        for (int p = 0; p < 2 * pairs; ++p) {
            const base_t<S> side = p % 2 ? 1 : -1;
            const S arm = k.middle + S(base_t<S>(side * node[p / 2])) * k.half_length;
            const V v_n = v.n + arm * v.w;
            const V quadratic = cross_flow ? v_n * speed(v.t, v_n) : times_abs(v_n);
            const V force = S(base_t<S>(-weight[p / 2])) * (k.drag * quadratic + k.linear_drag * v_n);
            f.n += force;
            f.w += arm * force;
        }
        return f;
    }

    /// Lighthill's reactive term at the trailing edge: the momentum and energy that the tail leaves behind in the
    /// wake. The factor v_t / |v| fades it out as the tail stops advancing, where the theory ends.
    template <class V>
    HYPERTUNA_INLINE Along<V> shed(const Along<V>& v) const {
        const V advance = max(-v.t, V(S(0)));
        const V k = shedding * advance / speed(v.t, v.n);
        return {S(base_t<S>(-0.5)) * k * v.n * v.n, k * v.t * v.n, V(S(0))};
    }

    /// |v|, kept off zero so that its derivative stays finite there.
    template <class V>
    static HYPERTUNA_INLINE V speed(const V& t, const V& n) {
        return sqrt(t * t + n * n + S(base_t<S>(1e-24)));
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
