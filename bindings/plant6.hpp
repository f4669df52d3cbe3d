/// The plant in space, the largest part of what its users compile: plant6.cpp does it for all of them.
#pragma once

#include "free_body.hpp"
#include "hypertuna/simulation/twin6.hpp"

// `keyword` is extern, or nothing where it is compiled.
#define HYPERTUNA_PLANT6_OF(keyword, Law, D)                                                                         \
    keyword template BodyAcceleration<double, D> body6_acceleration(                                                 \
        const Body6<double, Law<double>, D>&, const Bend<double, D>&, const SpatialTwist<double>&,                   \
        const Pose6<double>&, const double (&)[D]);                                                                  \
    keyword template PlantState<double, D, InSpace> plant_rate(                                                      \
        const Plant<Body6<double, Law<double>, D>>&, const PlantState<double, D, InSpace>&,                          \
        const ServoTargets<double, D>&, PlantOutput<double, D, InSpace>*);                                           \
    keyword template void follow_targets(const Twin<Body6<double, Law<double>, D>>&, TwinState<double, D, InSpace>&, \
                                         Tick<double, D, InSpace>&);
// clang-format off
#define HYPERTUNA_PLANT6_IN(keyword, D)     \
    HYPERTUNA_PLANT6_OF(keyword, Lumped, D) \
    HYPERTUNA_PLANT6_OF(keyword, Strip, D)
#define HYPERTUNA_PLANT6(keyword)   \
    HYPERTUNA_PLANT6_IN(keyword, 1) \
    HYPERTUNA_PLANT6_IN(keyword, 2) \
    HYPERTUNA_PLANT6_IN(keyword, 3) \
    HYPERTUNA_PLANT6_IN(keyword, 4) \
    HYPERTUNA_PLANT6_IN(keyword, 5)
// clang-format on

namespace hypertuna::inline HYPERTUNA_ARCH {
static_assert(most_coordinates == 5);
HYPERTUNA_PLANT6(extern)
}  // namespace hypertuna::inline HYPERTUNA_ARCH
