/// The paper's water law (Eqs 33-35): added mass alike in all directions, quadratic drag at the center of mass.
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Lumped {
    static constexpr const char* name = "lumped";
    static constexpr WaterColumn columns[] = {
        {"added_mass", true, "1"},      {"friction", true, "1"},    {"drag", true, "1"},
        {"friction_area", true, "m^2"}, {"drag_area", true, "m^2"},
    };
    static constexpr const char* flags[] = {nullptr};
    static constexpr bool sheds = false;
    static constexpr bool beats = false;

    struct Coefficients {
        S inertia_mass;  // m (1 + c_m), kg
        S inertia;       // kg m^2
        S friction;      // 1/2 rho c_f S, kg/m
        S drag;          // 1/2 rho c_d S, kg/m
    };
    const Coefficients* links;

    static Lumped read(int links, Columns<S>& in, const Link<S>* link, const S& density, unsigned, Coefficients* out) {
        const S* added_mass = in.take(links);
        const S* friction = in.take(links);
        const S* drag = in.take(links);
        const S* friction_area = in.take(links);
        const S* drag_area = in.take(links);
        const S half = S(base_t<S>(0.5)) * density;
        for (int i = 0; i < links; ++i)
            out[i] = {link[i].mass * (S(1) + added_mass[i]), link[i].inertia, half * friction[i] * friction_area[i],
                      half * drag[i] * drag_area[i]};
        return {out};
    }

    HYPERTUNA_INLINE LinkInertia<S> inertia(int i) const {
        return {links[i].inertia_mass, links[i].inertia_mass, S(0), links[i].inertia};
    }
    template <class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v) const {
        return {-(links[i].friction * times_abs(v.t)), -(links[i].drag * times_abs(v.n)), V(S(0))};
    }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
