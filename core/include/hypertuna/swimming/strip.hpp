/// Slender-body strips: added mass and drag per length, integrated along every link.
#pragma once

#include "hypertuna/swimming/tail_fin.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Strip {
    static constexpr const char* name = "strip";
    static constexpr WaterColumn columns[] = {
        {"lateral_area", true, "m^2"},       {"wetted_area", true, "m^2"},
        {"added_mass_normal", true, "1"},    {"added_mass_tangential", true, "1"},
        {"added_inertia", true, "1"},        {"drag_normal", true, "1"},
        {"drag_tangential", true, "1"},      {"linear_normal", true, "Pa s"},
        {"linear_tangential", true, "Pa s"}, {"tail_shedding", false, "1"},
        {"drag_beating", true, "1"},         {"blunt_area", true, "m^2"},
        {"edge_height", false, "m"},         {"edge_aspect", false, "1"},
        {"edge_added_mass", false, "1"},     {"edge_lift", false, "1"},
        {"edge_suction", false, "1"},
    };
    static constexpr const char* flags[] = {"cross_flow", nullptr};
    static constexpr bool sheds = true;
    static constexpr bool beats = true;

    struct Coefficients {
        LinkInertia<S> inertia;        // link's inertia with added mass
        S friction, linear_friction;   // along the whole link: kg/m, kg/s
        S drag, beating, linear_drag;  // across the whole link: kg/m, kg/m, kg/s
        S middle, half_length;         // middle of the link from its center of mass, and half its length, m
    };
    const Coefficients* links;
    TailFin<S> fin;
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
        const S* edge_aspect = in.take(1);
        const S* edge_added_mass = in.take(1);
        const S* edge_lift = in.take(1);
        const S* edge_suction = in.take(1);
        const S half = S(base_t<S>(0.5)) * density, quarter_pi(base_t<S>(pi / 4)), twelfth(base_t<S>(1.0 / 12));
        S added(0), ahead(0), height(0);  // last link: added mass per length; heights of the link ahead and its own
        for (int i = 0; i < links; ++i) {
            ahead = height;
            height = lateral_area[i] / link[i].length;
            const S length = link[i].length;
            const S reference = density * quarter_pi * height * height;  // kg/m: a plate of this height, broadside
            added = added_normal[i] * reference;
            const S normal = added * length, middle = S(base_t<S>(0.5)) * length - link[i].com;
            out[i] = {{link[i].mass + added_tangential[i] * reference * length, link[i].mass + normal, normal * middle,
                       link[i].inertia + normal * (middle * middle + added_inertia[i] * twelfth * length * length)},
                      half * drag_tangential[i] * wetted_area[i] + half * blunt_area[i],
                      linear_tangential[i] * length,
                      half * drag_normal[i] * lateral_area[i],
                      half * drag_beating[i] * lateral_area[i],
                      linear_normal[i] * length,
                      middle,
                      S(base_t<S>(0.5)) * length};
        }
        const int last = links - 1;
        const Link<S>& tail = link[last];
        const S zero(0), tiny(base_t<S>(1e-12)), edge_mass = density * quarter_pi * *edge_height * *edge_height;
        const S span = select(zero < *edge_height, *edge_height, height), step = ahead / span;
        const S shed = *tail_shedding * *edge_lift * select(zero < *edge_height, edge_mass, added);
        const S chord = *edge_height / max(*edge_aspect, tiny), total = added * tail.length;
        const EdgePlate<S> plate{min(*edge_added_mass * density * quarter_pi * chord * chord * *edge_height, total),
                                 chord, shed, *edge_lift, *edge_suction};
        const EdgeStrip<S> strip{added, shed, min(step * step, S(1)), *edge_suction};
        // A fin that is longer than the last link spans several links, of which the last one ends it.
        const S length_left = S(base_t<S>(1.0001)) * tail.length - chord;
        const auto is_plate = zero < min(min(*edge_height, *edge_aspect), length_left);
        LinkInertia<S>& inertia = out[last].inertia;
        inertia =
            select(is_plate, plate.inertia(tail, inertia.tangential - tail.mass, total, added_inertia[last]), inertia);
        return {out, select(is_plate, plate.fin(tail), strip.fin(tail)), (flag_bits & 1u) != 0};
    }

    // By reference: a copy takes longer than the product that it enters.
    HYPERTUNA_INLINE const LinkInertia<S>& inertia(int i) const { return links[i].inertia; }

    /// Drag on link i at the velocity v; `bend` is the part of v that the change of shape makes.
    template <class G, class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v, const Along<G>& bend) const {
        const Coefficients& k = links[i];
        // Beating's share of the squared normal speed at the link's middle.
        const V beat = V(bend.n) + k.middle * V(bend.w), steady = v.n + k.middle * v.w - beat, square = beat * beat;
        const V across = k.drag + k.beating * (square / (square + steady * steady + V(S(base_t<S>(1e-24)))));
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
        return fin.force(v);
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
