/// Quantities of a settled beat, each declared once: name, unit, label, meaning and formula. Evaluated with dual
/// numbers, the formula gives the derivative. Python, the C interface and the studio read this table.
#pragma once

#include <algorithm>

#include "hypertuna/swimming/settle.hpp"

namespace hypertuna {

// Turning radii in body lengths: a body with a larger one than the first swims straight; summaries show none beyond the
// second.
inline constexpr double straight = 1e6, nearly_straight = 1e3;

/// Where a quantity is shown: only in data sets of sweeps, also in records of JSON, or also in summaries on screens.
enum class Shown { data, record, summary };
/// Whether an optimization seeks large or small values, or cannot have the quantity as its objective.
enum class Better { neither, large, small };

/// How a host presents a quantity.
struct QuantityAbout {
    const char *name, *unit, *label, *meaning;
    Shown shown;
    Better better;
    bool differentiable;  // its formula may be evaluated with dual numbers
};

}  // namespace hypertuna

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Arguments of the formulas, which `measured` and `settle_into` of host/rows.hpp fill in: a beat with its gait and
/// robot, and the results of its search, which have no derivatives.
template <class S>
struct Measured {
    BeatNumbers<S> beat;
    S speed;                    // m/s: `mean_speed` of beat.hpp
    int groups;                 // number of joint groups
    const Harmonic<S>* group;   // command of each joint group
    S frequency, length, mass;  // Hz; m and kg, of the whole body
    S towed_power;              // W, power to tow the straight body at this speed
    S residual, distance, beats;
};

template <class S>
struct Quantity {
    QuantityAbout about;
    S (*of)(const Measured<S>&);  // null where the quantity follows from other columns
};

template <class S>
inline constexpr Quantity<S> quantities[] = {
    {{"speed", "m/s", "speed",
      "mean speed along the path through the water, forward positive; NaN for a body that spins", Shown::summary,
      Better::large, true},
     [](const auto& m) { return m.speed; }},
    {{"speed_bl", "BL/s", "speed", "speed in body lengths per second", Shown::summary, Better::large, true},
     [](const auto& m) { return m.speed / m.length; }},
    {{"mechanical_power", "W", "mechanical power", "mean mechanical power of all joints", Shown::summary, Better::small,
      true},
     [](const auto& m) { return m.beat.power; }},
    {{"mechanical_power_positive", "W", "mechanical power positive",
      "mean mechanical power, negative power of a joint group counted as zero", Shown::record, Better::small, true},
     [](const auto& m) { return m.beat.power_positive; }},
    {{"power_to_water", "W", "power to water", "mean power that the water takes", Shown::record, Better::small, true},
     [](const auto& m) { return m.beat.loss; }},
    {{"cost_of_transport", "J/(kg m)", "cost of transport", "mechanical power per mass and speed", Shown::summary,
      Better::small, true},
     [](const auto& m) { return m.beat.power / (m.mass * abs(m.speed)); }},
    {{"cost_of_transport_positive", "J/(kg m)", "cost of transport positive", "the same of the positive power",
      Shown::record, Better::small, true},
     [](const auto& m) { return m.beat.power_positive / (m.mass * abs(m.speed)); }},
    {{"strouhal", "", "Strouhal number", "frequency times peak-to-peak tail excursion over speed", Shown::summary,
      Better::small, true},
     [](const auto& m) { return m.frequency * m.beat.excursion / abs(m.speed); }},
    {{"stride_length", "BL per beat", "stride length", "body lengths per beat", Shown::summary, Better::large, true},
     [](const auto& m) { return m.speed / (m.frequency * m.length); }},
    {{"efficiency", "", "efficiency", "power to tow the straight body at this speed over mechanical power",
      Shown::summary, Better::large, false},
     [](const auto& m) {
         const S none(std::numeric_limits<base_t<S>>::quiet_NaN());
         return select(S(0) < m.beat.power, m.towed_power / m.beat.power, none);
     }},
    {{"tail_excursion", "m", "tail excursion, peak to peak",
      "excursion of the tail tip across the mean path, peak to peak", Shown::summary, Better::small, true},
     [](const auto& m) { return m.beat.excursion; }},
    {{"torque_peak", "N m", "peak torque", "largest magnitude of any driven joint's torque over the beat", Shown::data,
      Better::small, true},
     [](const auto& m) { return m.beat.torque_peak; }},
    {{"rate_peak", "rad/s", "peak rate", "largest rate of any joint group over the beat", Shown::data, Better::small,
      true},
     [](const auto& m) { return largest_rate(m.groups, m.group, m.frequency); }},
    {{"turn_rate", "rad/s", "turn rate, counter-clockwise", "mean rate of turn, counter-clockwise", Shown::summary,
      Better::neither, true},
     [](const auto& m) { return m.beat.displacement.heading * m.frequency; }},
    {{"turn_radius", "m", "turn radius",
      "mean distance of the nose from the center of the turn; infinite when straight, NaN for a body that spins",
      Shown::summary, Better::small, false},
     [](const auto& m) {
         const S infinite(std::numeric_limits<base_t<S>>::infinity());
         return select(S(base_t<S>(straight)) * m.length <= m.beat.radius, infinite, m.beat.radius);
     }},
    {{"spectral_radius", "", "spectral radius",
      "largest modulus of the monodromy's multipliers: growth of a disturbance per beat", Shown::data, Better::neither,
      false},
     nullptr},  // computed from the monodromy's column by its reader
    {{"change_per_beat", "", "change per beat", "change of the motion from beat to beat, body lengths or rad",
      Shown::data, Better::neither, false},
     [](const auto& m) { return m.residual; }},
    {{"distance_to_settled", "", "distance to settled",
      "distance from the settled motion, over the distance traveled in a beat", Shown::data, Better::neither, false},
     [](const auto& m) { return m.distance; }},
    {{"beats", "", "beats", "beats integrated", Shown::data, Better::neither, false},
     [](const auto& m) { return m.beats; }},
};
inline constexpr int derivative_count =
    int(std::ranges::count_if(quantities<double>, [](const auto& quantity) { return quantity.about.differentiable; }));

}  // namespace hypertuna::inline HYPERTUNA_ARCH
