/// Templates of the plant in space, the largest part of the code that their users compile: plant6.cpp compiles them for
/// all.
#pragma once

#include "hypertuna/host/body.hpp"
#include "hypertuna/simulation/twin6.hpp"

// `keyword` is extern, or empty in the file that compiles the templates.
#define HYPERTUNA_PLANT6_OF(keyword, Law, D)                                                       \
    keyword template BodyAcceleration<double, D> body6_acceleration(                               \
        const Body6<double, Law<double>, D>&, const Bend<double, D>&, const SpatialTwist<double>&, \
        const Pose6<double>&, const double (&)[D]);                                                \
    keyword template PlantState<double, D, InSpace> plant_rate(                                    \
        const Plant<Body6<double, Law<double>, D>>&, const PlantState<double, D, InSpace>&,        \
        const ServoTargets<double, D>&, PlantOutput<double, D, InSpace>*);                         \
    keyword template void follow_targets(const Machine<Body6<double, Law<double>, D>>&,            \
                                         MachineState<double, D, InSpace>&, MachineTick<double, D, InSpace>&);
#define HYPERTUNA_PLANT6_ALL(keyword, Law) \
    HYPERTUNA_PLANT6_OF(keyword, Law, 1)   \
    HYPERTUNA_PLANT6_OF(keyword, Law, 2)   \
    HYPERTUNA_PLANT6_OF(keyword, Law, 3)   \
    HYPERTUNA_PLANT6_OF(keyword, Law, 4)   \
    HYPERTUNA_PLANT6_OF(keyword, Law, 5) HYPERTUNA_PLANT6_OF(keyword, Law, max_coordinates)
#define HYPERTUNA_PLANT6_EXTERN(Law) HYPERTUNA_PLANT6_ALL(extern, Law)
#define HYPERTUNA_PLANT6_HERE(Law) HYPERTUNA_PLANT6_ALL(, Law)

namespace hypertuna::inline HYPERTUNA_ARCH {
static_assert(exact_tail == 5);
HYPERTUNA_WATER_LAWS(HYPERTUNA_PLANT6_EXTERN)
}  // namespace hypertuna::inline HYPERTUNA_ARCH
