/// What is asked of the search for a settled beat, and what becomes of it: the same for every host.
#pragma once

#include <cmath>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna {

inline constexpr int beat_steps = 128;       // Runge-Kutta steps of a beat: 8e-7 of the speed, 2e-6 of the power
inline constexpr int newton_beats = 60;      // of each stage of Newton's method
inline constexpr int approach_beats = 2000;  // at most in which a start from rest is followed toward a settled beat
inline constexpr double neutral = 1 + 1e-6;  // largest multiplier of a body at rest, which keeps a disturbance: 1 but
                                             // for rounding
inline constexpr double straight = 1e6;      // body lengths: a larger turning radius is no turn

enum class BeatStatus { settled, unsettled, unstable, diverged };
inline constexpr const char* beat_statuses[] = {"settled", "unsettled", "unstable", "diverged"};

/// Whether a beat turns the body by more than half a circle [rad]: it has no path then, and no speed along it.
inline bool spins(double turn) { return pi < std::abs(turn); }

}  // namespace hypertuna
