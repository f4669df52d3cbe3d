/// Lighthill's large-amplitude elongated-body theory (1971) with resistive drag: the momentum of the water is only
/// across the body, and what reaches the trailing edge is left in the wake. Derivation: docs/model.md.
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Elongated {
    static constexpr const char* name = "elongated";
    static constexpr WaterColumn columns[] = {
        {"lateral_area", true, "m^2"},   {"wetted_area", true, "m^2"}, {"added_mass_normal", true, "1"},
        {"added_mass_edge", false, "1"}, {"drag_normal", true, "1"},   {"drag_tangential", true, "1"},
    };
    static constexpr const char* flags[] = {nullptr};
    static constexpr bool sheds = true;
    static constexpr bool beats = false;

    struct Coefficients {
        LinkInertia<S> inertia;  // link's inertia with added mass
        S friction, drag;        // along and across the whole link, kg/m
        S middle, half_length;   // middle of the link from its center of mass, and half its length, m
    };
    const Coefficients* links;
    S shedding;  // kg/m: added mass per length at the trailing edge
    S edge;      // m, of the trailing edge behind the last link's center of mass

    static Elongated read(int links, Columns<S>& in, const Link<S>* link, const S& density, unsigned,
                          Coefficients* out) {
        const S* lateral_area = in.take(links);
        const S* wetted_area = in.take(links);
        const S* added_normal = in.take(links);
        const S* added_edge = in.take(1);
        const S* drag_normal = in.take(links);
        const S* drag_tangential = in.take(links);
        const S half(base_t<S>(0.5)), quarter_pi(base_t<S>(pi / 4)), twelfth(base_t<S>(1.0 / 12));
        S plate(0);  // kg/m: added mass of a plate as high as the link, broadside
        for (int i = 0; i < links; ++i) {
            const S length = link[i].length, height = lateral_area[i] / length;
            plate = density * quarter_pi * height * height;
            const S added = added_normal[i] * plate * length, middle = half * length - link[i].com;
            out[i] = {{link[i].mass, link[i].mass + added, added * middle,
                       link[i].inertia + added * (middle * middle + twelfth * length * length)},
                      half * density * drag_tangential[i] * wetted_area[i],
                      half * density * drag_normal[i] * lateral_area[i],
                      middle,
                      half * length};
        }
        return {out, *added_edge * plate, link[links - 1].length - link[links - 1].com};
    }

    HYPERTUNA_INLINE const LinkInertia<S>& inertia(int i) const { return links[i].inertia; }

    template <class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v) const {
        const Coefficients& k = links[i];
        Along<V> f = {-(k.friction * times_abs(v.t)), V(S(0)), V(S(0))};
        for (int p = 0; p < 2 * Gauss4::pairs; ++p) {
            const base_t<S> side = p % 2 ? 1 : -1;
            const S arm = k.middle + S(base_t<S>(side * Gauss4::node[p / 2])) * k.half_length;
            const V force = S(base_t<S>(-Gauss4::weight[p / 2])) * (k.drag * times_abs(v.n + arm * v.w));
            f.n += force;
            f.w += arm * force;
        }
        return f;
    }

    /// Lighthill's force at the trailing edge; an edge that moves backward leaves no momentum behind.
    template <class V>
    HYPERTUNA_INLINE Along<V> shed(const Along<V>& v) const {
        const V across = v.n + edge * v.w;
        const Along<V> f = wake_force<S>(shedding, Along<V>{min(v.t, V(S(0))), across, v.w});
        return {f.t, f.n, edge * f.n};
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
