/// Water: the inertia that it adds to a link, and the drag that it exerts.
///
/// A water law is a type Law<S> in a file of its own beside this one, listed in laws.hpp:
///     name, columns, flags               its table [water.NAME] in a robot file, and the order of its coefficients
///     read(links, in, link, density, flags, out)   the law from one row of coefficients, its memory `out`
///     LinkInertia<S> inertia(i)          inertia of link i with its added mass
///     Along<V> drag(i, Along<V> v)       force along and across link i and moment about its center of mass
///     beats                              whether drag takes a third argument: of v, the part by the change of shape
///     sheds, Along<V> shed(Along<V> v)   whether the last link sheds a wake, and its force on that link
/// Of the part by the change of shape only what is across the link, and its rate of turn, may enter.
/// Velocities are relative to the water. A uniform current only carries the frame along (physics is the same
/// in every inertial frame), so it appears where positions are reported and nowhere here.
#pragma once

#include "hypertuna/swimming/chain.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// One coefficient of a water law: one value per link, or a single one.
struct WaterColumn {
    const char* name;
    bool per_link;
    const char* unit;
};

/// Reads one column of numbers after another.
template <class S>
struct Columns {
    const S* next;

    const S* take(int count) {
        const S* column = next;
        next += count;
        return column;
    }
};

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

/// Gauss-Legendre nodes and weights on [-1, 1]: a pair of nodes at +-node; the weights of all four add up to 1.
struct Gauss4 {
    static constexpr int pairs = 2;
    static constexpr double node[pairs] = {0.33998104358485626, 0.86113631159405258};
    static constexpr double weight[pairs] = {0.32607257743127307, 0.17392742256872693};
};

/// |v|, kept off zero so that its derivative stays finite there.
template <class S, class V>
HYPERTUNA_INLINE V magnitude(const V& t, const V& n) {
    return sqrt(t * t + n * n + S(base_t<S>(1e-24)));
}

/// Lighthill's reactive force at a trailing edge that moves at v and leaves momentum and energy in the wake, for an
/// added mass of k [kg/m] there: -1/2 k v_n^2 along and k v_t v_n across.
template <class S, class K, class V>
HYPERTUNA_INLINE Along<V> wake_force(const K& k, const Along<V>& v) {
    return {S(base_t<S>(-0.5)) * k * v.n * v.n, k * v.t * v.n, V(S(0))};
}

/// Lighthill's force times v_t / |v|: the force fades as the edge stops advancing.
template <class S, class V>
HYPERTUNA_INLINE Along<V> faded_wake_force(const S& added_mass, const Along<V>& v) {
    const V advance = max(-v.t, V(S(0)));
    return wake_force<S>(added_mass * advance / magnitude<S>(v.t, v.n), v);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
