/// Parameters: everything about a robot, its water and its gait that has a derivative, as one row of numbers.
///
/// Order (n links, g joint groups):
///     frequency 1 | amplitude g | phase g | bias g |
///     bandwidth g | phase_offset g |
///     length n | com n | mass n | inertia n | density 1 | coefficients of the water law
/// lumped: added_mass n | friction n | drag n | friction_area n | drag_area n
/// strip:  lateral_area n | wetted_area n | added_mass_normal n | added_mass_tangential n | added_inertia n |
///         drag_normal n | drag_tangential n | linear_normal n | linear_tangential n | tail_shedding 1
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Reads one named column after another.
template <class S>
struct Columns {
    const S* next;

    const S* take(int count) {
        const S* column = next;
        next += count;
        return column;
    }
};

inline constexpr int gait_parameters(int groups) { return 1 + 3 * groups; }  // the rest is the robot's

/// The shape of the body depends on these first ones alone: gait, lags of the joints, lengths and centers of mass.
inline constexpr int shape_parameters(int groups, int links) { return 1 + 5 * groups + 2 * links; }

/// Frequency, and each group's harmonic with the lags of its joints.
template <class S>
S read_gait(int groups, Columns<S>& in, Harmonic<S>* out) {
    const S frequency = *in.take(1);
    const S* amplitude = in.take(groups);
    const S* phase = in.take(groups);
    const S* bias = in.take(groups);
    const S* bandwidth = in.take(groups);
    const S* phase_offset = in.take(groups);
    for (int g = 0; g < groups; ++g) out[g] = {amplitude[g], phase[g], bias[g], bandwidth[g], phase_offset[g]};
    return frequency;
}

/// Density of the water, and the links.
template <class S>
S read_body(int links, Columns<S>& in, Link<S>* out) {
    const S* length = in.take(links);
    const S* com = in.take(links);
    const S* mass = in.take(links);
    const S* inertia = in.take(links);
    for (int i = 0; i < links; ++i) out[i] = {length[i], com[i], mass[i], inertia[i]};
    return *in.take(1);
}

template <class S>
Lumped<S> read_water(int links, Columns<S>& in, const Link<S>* link, const S& density, bool,
                     typename Lumped<S>::Coefficients* out) {
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

template <class S>
Strip<S> read_water(int links, Columns<S>& in, const Link<S>* link, const S& density, bool cross_flow,
                    typename Strip<S>::Coefficients* out) {
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
    const S half = S(base_t<S>(0.5)) * density, quarter_pi(base_t<S>(pi / 4)), twelfth(base_t<S>(1.0 / 12));
    S edge(0);
    for (int i = 0; i < links; ++i) {
        const S length = link[i].length, height = lateral_area[i] / length;
        const S reference = density * quarter_pi * height * height;  // kg/m: a plate of this height, broadside
        const S normal = added_normal[i] * reference * length;
        const S middle = S(base_t<S>(0.5)) * length - link[i].com;
        out[i] = {{link[i].mass + added_tangential[i] * reference * length, link[i].mass + normal, normal * middle,
                   link[i].inertia + normal * (middle * middle + added_inertia[i] * twelfth * length * length)},
                  half * drag_tangential[i] * wetted_area[i],
                  linear_tangential[i] * length,
                  half * drag_normal[i] * lateral_area[i],
                  linear_normal[i] * length,
                  middle,
                  S(base_t<S>(0.5)) * length};
        edge = added_normal[i] * reference;
    }
    return {out, *tail_shedding * edge, cross_flow};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
