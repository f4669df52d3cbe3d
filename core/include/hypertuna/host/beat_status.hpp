/// Options of the search for a settled beat, its outcome, and the outcome in words: the same for every host.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna {

inline constexpr int beat_steps = 128;  // Runge-Kutta steps per beat: errors of 8e-7 of the speed and 2e-6 of the power
inline constexpr int newton_beats = 60;  // largest number of beats in each stage of Newton's method
inline constexpr int approach_beats =
    2000;  // largest number of beats over which a start from rest is followed toward a settled beat
inline constexpr double neutral =
    1 + 1e-6;  // largest multiplier that still counts as stable: that of a body at rest is 1 but for rounding

enum class BeatStatus { settled, unsettled, unstable, diverged, unresolved };
inline constexpr const char* beat_statuses[] = {"settled", "unsettled", "unstable", "diverged", "unresolved"};

/// Status of a search from its status without stability (`found`) and the largest multiplier of the monodromy.
inline BeatStatus status_of(double found, double spectral_radius) {
    return found == 0 && neutral < spectral_radius ? BeatStatus::unstable : BeatStatus(int(found));
}

/// Whether a beat turns the body by more than half a circle [rad]: it has no path then, and no speed along it.
inline bool spins(double turn) { return pi < std::abs(turn); }

/// Format numbers as `printf` does.
template <class... Number>
std::string written(const char* format, Number... numbers) {
    char text[192];
    std::snprintf(text, sizeof text, format, numbers...);
    return text;
}

/// Words on how a disturbance of a settled beat decays.
inline std::string decay_text(double spectral_radius) {
    const double loss = 100 * (1 - spectral_radius);
    if (std::isnan(loss)) return "";
    if (loss < 0.01) return "; a disturbance hardly decays";
    if (loss < 5) return written("; a disturbance decays slowly, by %.2g %% each beat", loss);
    return written("; a disturbance decays by %.0f %% each beat", loss);
}

/// The verdict on a beat that turns the body by `turn` [rad] as a sentence or two.
inline std::string verdict(BeatStatus status, double beats, double distance, double spectral_radius, double turn) {
    std::string text;
    switch (status) {
        case BeatStatus::settled:
            text = written("The gait is settled: consecutive beats agree to %.1e of the distance traveled", distance) +
                   decay_text(spectral_radius) + ".";
            break;
        case BeatStatus::unstable:
            text = "The gait is periodic but unstable: a disturbance grows " +
                   (spectral_radius < 2 ? written("by %.2g %%", 100 * (spectral_radius - 1))
                                        : written("to %.3g times its size", spectral_radius)) +
                   " each beat, so the robot will not stay in it.";
            break;
        case BeatStatus::unsettled:
            text = written(
                "The gait is unsettled after %.0f beats: it is still off by %.1e of the distance traveled in "
                "a beat.",
                beats, distance);
            break;
        case BeatStatus::diverged:
            return written("The gait diverged within %.0f beats: its speeds grew beyond all bounds; ", beats) +
                   "check the robot first (`hypertuna robot check FILE`), then use more steps per beat.";
        case BeatStatus::unresolved:
            return "The gait was not swum: a spring is too stiff, or too damped, for as many steps as a beat of this "
                   "frequency has at most; make it softer, or leave the hinge out for a rigid joint.";
    }
    if (spins(turn))
        text += written(" It spins: %.0f deg a beat, more than half a circle, is no path with a speed.",
                        std::abs(turn * (180 / pi)));
    return text;
}

}  // namespace hypertuna
