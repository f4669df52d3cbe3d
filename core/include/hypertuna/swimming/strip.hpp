/// Slender-body strips: added mass and drag per length, integrated along every link.
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Strip {
    static constexpr const char* name = "strip";
    static constexpr WaterColumn columns[] = {
        {"lateral_area", true, "m^2"},        {"wetted_area", true, "m^2"},    {"added_mass_normal", true, "1"},
        {"added_mass_tangential", true, "1"}, {"added_inertia", true, "1"},    {"drag_normal", true, "1"},
        {"drag_tangential", true, "1"},       {"linear_normal", true, "Pa s"}, {"linear_tangential", true, "Pa s"},
        {"tail_shedding", false, "1"},        {"drag_beating", true, "1"},     {"blunt_area", true, "m^2"},
        {"edge_height", false, "m"},          {"edge_lift", false, "1"},       {"edge_suction", false, "1"},
    };
    static constexpr const char* flags[] = {"cross_flow", nullptr};
    static constexpr bool sheds = true;
    static constexpr bool beats = true;

    struct Coefficients {
        LinkInertia<S> inertia;        // with added mass
        S friction, linear_friction;   // along the whole link: kg/m, kg/s
        S drag, beating, linear_drag;  // across it, whole link: kg/m, kg/m, kg/s
        S middle, half_length;         // of the link, from its center of mass, m
    };
    const Coefficients* links;
    S shedding;       // kg/m: coefficient times lift and added mass per length at the trailing edge
    S suction;        // force along the last link, in units of Lighthill's
    bool cross_flow;  // normal drag as v_n |v| instead of v_n |v_n|

    static Strip read(int links, Columns<S>& in, const Link<S>* link, const S& density, unsigned flag_bits,
                      Coefficients* out) {
        const S* lateral_area = in.take(links);
        const S* wetted_area = in.take(links);
        const S* added_normal = in.take(links);
        const S* added_tangential = in.take(links);
        const S* added_inertia = in.take(links);
        const S* drag_normal = in.take(links);
        const S* drag_tangential = in.take(links);
        const S* linear_normal = in.take(links);
        const S* linear_tangential = in.take(links);
        const S* tail_shedding = in.take(1);
        const S* drag_beating = in.take(links);
        const S* blunt_area = in.take(links);
        const S* edge_height = in.take(1);
        const S* edge_lift = in.take(1);
        const S* edge_suction = in.take(1);
        const S half = S(base_t<S>(0.5)) * density, quarter_pi(base_t<S>(pi / 4)), twelfth(base_t<S>(1.0 / 12));
        S edge(0);
        for (int i = 0; i < links; ++i) {
            const S length = link[i].length, height = lateral_area[i] / length;
            const S reference = density * quarter_pi * height * height;  // kg/m: a plate of this height, broadside
            const S normal = added_normal[i] * reference * length;
            const S middle = S(base_t<S>(0.5)) * length - link[i].com;
            out[i] = {{link[i].mass + added_tangential[i] * reference * length, link[i].mass + normal, normal * middle,
                       link[i].inertia + normal * (middle * middle + added_inertia[i] * twelfth * length * length)},
                      half * drag_tangential[i] * wetted_area[i] + half * blunt_area[i],
                      linear_tangential[i] * length,
                      half * drag_normal[i] * lateral_area[i],
                      half * drag_beating[i] * lateral_area[i],
                      linear_normal[i] * length,
                      middle,
                      S(base_t<S>(0.5)) * length};
            edge = added_normal[i] * reference;
        }
        const S own = density * quarter_pi * *edge_height * *edge_height;
        edge = select(S(0) < *edge_height, own, edge);
        return {out, *tail_shedding * *edge_lift * edge, *edge_suction * (S(2) - *edge_lift), (flag_bits & 1u) != 0};
    }

    // By reference: a copy takes longer than the product that it enters.
    HYPERTUNA_INLINE const LinkInertia<S>& inertia(int i) const { return links[i].inertia; }

    /// `bend` is what the change of shape alone makes of v.
    template <class G, class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v, const Along<G>& bend) const {
        const Coefficients& k = links[i];
        // Share of the square of the speed across at the link's middle that beating makes.
        const V beat = V(bend.n) + k.middle * V(bend.w), rest = v.n + k.middle * v.w - beat, square = beat * beat;
        const V across = k.drag + k.beating * (square / (square + rest * rest + V(S(base_t<S>(1e-24)))));
        Along<V> f = {-(k.friction * times_abs(v.t) + k.linear_friction * v.t), V(S(0)), V(S(0))};
        for (int p = 0; p < 2 * Gauss4::pairs; ++p) {
            const base_t<S> side = p % 2 ? 1 : -1;
            const S arm = k.middle + S(base_t<S>(side * Gauss4::node[p / 2])) * k.half_length;
            const V v_n = v.n + arm * v.w;
            const V quadratic = cross_flow ? v_n * magnitude<S>(v.t, v_n) : times_abs(v_n);
            const V force = S(base_t<S>(-Gauss4::weight[p / 2])) * (across * quadratic + k.linear_drag * v_n);
            f.n += force;
            f.w += arm * force;
        }
        return f;
    }

    template <class V>
    HYPERTUNA_INLINE Along<V> shed(const Along<V>& v) const {
        const Along<V> f = faded_wake_force(shedding, v);
        return {suction * f.t, f.n, f.w};
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
