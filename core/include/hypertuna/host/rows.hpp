/// Settled beats as rows of numbers, for bodies with any state: gaits go in lane by lane, and the results of the search
/// come out.
#pragma once

#include <algorithm>
#include <vector>

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/host/real.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/swimming/quantities.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Set a lane of a number; derivatives, where it has some, stay as they are.
template <class S>
void put_lane(S& x, int k, double y) {
    if constexpr (requires { x.d; })
        set_lane(x.v, k, y);
    else
        set_lane(x, k, y);
}

/// Write gaits into the lanes of the parameters; beyond the last gait the last one is repeated.
template <class S>
void load_gaits(const Model& model, const GaitBatch& gaits, int first, int end, std::vector<S>& parameters) {
    const int g = model.groups;
    for (int k = 0; k < lanes; ++k) {
        const int gait = std::min(first + k, end - 1);
        put_lane(parameters[0], k, gaits.frequency[gait]);
        for (int i = 0; i < g; ++i) {
            put_lane(parameters[1 + i], k, gaits.amplitude[gait * g + i]);
            put_lane(parameters[1 + g + i], k, gaits.phase[gait * g + i]);
            put_lane(parameters[1 + 2 * g + i], k, gaits.bias[gait * g + i]);
        }
    }
}

/// Writes numbers into rows, one row per lane, from gait `first` on.
struct LaneRows {
    double* rows;
    int width, first, end;
    int column = 0;

    void operator()(const Real& value) {
        for (int k = 0; k < lanes && first + k < end; ++k)
            rows[std::size_t(first + k) * width + column] = lane(value, k);
        ++column;
    }
};

/// Columns of a row after the quantities; the state at the start and the monodromy follow.
inline constexpr const char* found_columns[] = {"status", "arrived", "approach_beats", "retry", "u", "v", "r"};
inline constexpr int quantity_count = int(std::size(quantities<Real>)),
                     named_columns = quantity_count + int(std::size(found_columns));
inline constexpr int row_width(int state) { return named_columns + state * (1 + state); }

/// Arguments of the quantities' formulas, as far as they have derivatives.
template <class S, class Law, class G>
Measured<S> measured(const BeatNumbers<S>& beat, const Tank<S, Law, G>& tank, double length, double mass) {
    const S zero(base_t<S>(0.0));
    return {beat,
            mean_speed(beat, tank.frequency),
            int(tank.groups.size()),
            tank.groups.data(),
            tank.frequency,
            S(base_t<S>(length)),
            S(base_t<S>(mass)),
            zero,
            zero,
            zero,
            zero};
}

/// Find the settled beat of the gaits in the tank, by waiting or by Newton's method, and write it.
template <class Body, class Law>
Settled<Real, typename Body::State> settle_into(const Model& model, const Body& body, const Tank<Real, Law>& tank,
                                                const SettleOptions& options, LaneRows& write) {
    using Y = typename Body::State;
    const Real nan(std::numeric_limits<double>::quiet_NaN());
    const Y rest = filled<Y>(Real(0.0));  // joints that begin to move cannot give momentum
    Settled<Real, Y> s;
    if (options.wait >= 0) {
        s = wait(body, rest, options.wait);
    } else {
        Y guess = rest;
        for (int k = 0; k < options.from_rest; ++k) guess = body.swim(guess);
        if (options.from_rest < 0) {
            Momentum<Real> brisk =
                brisk_start(tank.table, model.groups, tank.swings.data(), tank.frequency, body.length);
            for (int k = 0; k < 3; ++k) component(guess, k) = component(brisk, k);
        }
        s = settle(body, guess, options.max_beats);
    }
    // No start is followed toward a beat that is not settled: its distance is NaN.
    const Y target = select(s.distance < Real(settle_tolerances.settled), s.start, filled<Y>(nan));
    const Approach<Real, Y> way = approach(body, target, options.approach);
    Measured<Real> m = measured(s.beat, tank, model.length, options.mass);
    m.towed_power = towing_power(tank.fish, m.speed);
    m.residual = s.residual, m.distance = s.distance, m.beats = s.beats;
    for (const auto& quantity : quantities<Real>) write(quantity.of ? quantity.of(m) : nan);
    const Twist<Real> xi = body.head(s.start);
    write(search_status(s, m.speed));
    write(select(way.distance < Real(approach_tolerances.arrived), Real(1.0), Real(0.0)));
    for (const Real& value : {way.beats, s.retry, xi.x, xi.y, xi.z}) write(value);
    for (int i = 0; i < Y::size; ++i) write(component(s.start, i));
    for (const auto& row : s.monodromy.a)
        for (const Real& value : row) write(value);
    return s;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
