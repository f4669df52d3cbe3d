/// Parameters: everything about a robot, its water and its gait that has a derivative, as one row of numbers.
///
/// Order (n links, g joint groups):
///     frequency 1 | amplitude g | phase g | bias g |
///     bandwidth g | phase_offset g |
///     length n | com n | mass n | inertia n | density 1 | columns of the water law
#pragma once

#include "hypertuna/swimming/laws.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int gait_parameters(int groups) { return 1 + 3 * groups; }  // number of the gait's parameters

/// Number of the first parameters, those on which the shape of the body depends: gait, lags of the joints, lengths and
/// centers of mass.
inline constexpr int shape_parameters(int groups, int links) { return 1 + 5 * groups + 2 * links; }

/// Where centers of mass and the density begin in a robot's row, which lacks the gait's parameters.
inline constexpr int com_place(int groups, int links) { return 2 * groups + links; }
inline constexpr int density_place(int groups, int links) { return 2 * groups + 4 * links; }

/// Read each group's harmonic with the lags of its joints, and return the frequency.
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

/// Read the links, and return the density of the water.
template <class S>
S read_body(int links, Columns<S>& in, Link<S>* out) {
    const S* length = in.take(links);
    const S* com = in.take(links);
    const S* mass = in.take(links);
    const S* inertia = in.take(links);
    for (int i = 0; i < links; ++i) out[i] = {length[i], com[i], mass[i], inertia[i]};
    return *in.take(1);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
