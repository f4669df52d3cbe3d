/// Losses: where the electrical power of the servos goes, share by share, from the motors to the water.
///
/// At every instant the shares add up to the power of the servos. The means of `rotor` and `elastic` over a beat are
/// nearly zero where the motion is periodic, and so is the part of `hinge` that springs store. The small remainder is
/// heat of the air that travels with the oil, which the line's flow does not count (docs/hydraulics.md).
#pragma once

#include "hypertuna/math/scalar.hpp"

/// List of all shares, X(name, place, sentence): where the power is lost, and in what.
#define HYPERTUNA_LOSSES(X)                                                                 \
    X(idle, "servos", "electronics of the servos, and what their motors take at rest")      \
    X(windings, "servos", "heat in the windings of the servos' motors")                     \
    X(gears, "servos", "friction of the servos' gears")                                     \
    X(seals, "servos", "friction of the pistons' seals")                                    \
    X(braking, "servos", "work that comes back to the servos, which they do not regain")    \
    X(rotor, "servos", "into the servos' rotors, less what comes back")                     \
    X(line, "oil", "drop of pressure along the oil lines")                                  \
    X(elastic, "oil", "into compressed oil, hoses and bent silicone, less what comes back") \
    X(braid, "joints", "friction of the drive units' braids")                               \
    X(silicone, "joints", "viscosity of the joints' silicone")                              \
    X(hinge, "joints", "damping of hinges, and into their springs, less what comes back")   \
    X(water, "water", "work of the joints on the tail in the water")

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Power of each share, W. All members are of type S.
template <class S>
struct Losses {
#define HYPERTUNA_EACH(name, from, sentence) S name;
    HYPERTUNA_LOSSES(HYPERTUNA_EACH)
#undef HYPERTUNA_EACH
};

/// Add a factor times other losses.
template <class S>
HYPERTUNA_INLINE void add(Losses<S>& to, const S& factor, const Losses<S>& losses) {
#define HYPERTUNA_EACH(name, from, sentence) to.name += factor * losses.name;
    HYPERTUNA_LOSSES(HYPERTUNA_EACH)
#undef HYPERTUNA_EACH
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
