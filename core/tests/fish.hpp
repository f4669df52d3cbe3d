/// A small swimmer to test with, and the memory for its beat. All its numbers are made up: four plates, somewhat
/// lighter toward the tail, moved by two joint groups through a first-order lag.
#pragma once

#include <cstdlib>
#include <random>
#include <string_view>
#include <utility>

#include "hypertuna/swimming/parameters.hpp"
#include "hypertuna/swimming/settle.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Parameters in the order of parameters.hpp, column by column.
template <class S>
struct ParameterRow {
    S number[90];
    int count = 0;

    void add(const S& x) { number[count++] = x; }
    template <class Column>
    void add_each(int links, const Column& column) {
        for (int i = 0; i < links; ++i) add(S(base_t<S>(column(i))));
    }
};

template <class S, class Law, int steps = 64>
struct Fish {
    static constexpr int links = 4, groups = 2;
    static constexpr double lengths[links] = {0.2, 0.1, 0.06, 0.08};
    static constexpr double heights[links] = {0.1, 0.08, 0.04, 0.1};
    static constexpr double density = 1000.0, thickness = 0.02;

    S frequency, period, length;
    Harmonic<S> harmonics[groups];
    Swing<S> swings[groups];
    JointShare<S> joints[links];
    Link<S> link[links];
    typename Law::Coefficients coefficients[links];
    Swimmer<S, Law> swimmer;
    ShapeTable<S> table;
    BeatScratch<S> scratch;

    Fish(const S& beat_frequency, const S& amplitude, unsigned flags = 0) {
        ParameterRow<S> row;
        write_gait(beat_frequency, amplitude, row);
        write_body(row);
        write_water(row);
        Columns<S> in{row.number};
        frequency = read_gait(groups, in, harmonics);
        const S rho = read_body(links, in, link);
        swimmer = {links, link, Law::read(links, in, link, rho, flags, coefficients)};
        period = S(1) / frequency;
        length = S(0);
        for (const Link<S>& l : link) length += l.length;
        for (int g = 0; g < groups; ++g) swings[g] = response(harmonics[g], frequency);
        const S half(base_t<S>(0.5));
        joints[0] = {-1, S(0)};
        joints[1] = {0, S(1)};
        joints[2] = joints[3] = {1, half};
        table = {links, 2 * steps, shape_, acceleration_, mobility_, momentum_};
        scratch = {torque_, group_power_, sample_};
        fill();
    }
    Fish(const Fish&) = delete;
    Fish& operator=(const Fish&) = delete;

    /// Tabulate the beat again, for example after a change of coefficients.
    void fill() { tabulate_beat(swimmer, joints, swings, frequency, motion_, table); }

    /// The moving shape at phase 2 pi f t, in instant 0 of the table.
    Instant<S> at_phase(const S& phase) {
        joint_motion(links, joints, swings, frequency, sincos(phase), motion_);
        tabulate(swimmer, motion_, 0, table);
        return table[0];
    }

    PeriodicSwimmer<S, Law> body() const { return {swimmer, joints, table, length, period, scratch}; }
    Momentum<S> rest() const { return {S(0), S(0), S(0)}; }
    Momentum<S> brisk() const { return brisk_start(table, groups, swings, frequency, length); }

  private:
    static void write_gait(const S& beat_frequency, const S& amplitude, ParameterRow<S>& row) {
        const base_t<S> lag = base_t<S>(0.7), bias = base_t<S>(0.05), bandwidth = 5;
        row.add(beat_frequency);
        row.add(amplitude), row.add(amplitude + amplitude);
        row.add(S(0)), row.add(S(lag));
        row.add(S(bias)), row.add(S(-bias));
        row.add(S(bandwidth)), row.add(S(bandwidth));
        row.add(S(0)), row.add(S(0.5 * lag));
    }
    static void write_body(ParameterRow<S>& row) {
        const auto mass = [](int i) { return density * thickness * lengths[i] * heights[i]; };
        row.add_each(links, [](int i) { return lengths[i]; });
        row.add_each(links, [](int i) { return 0.45 * lengths[i]; });
        row.add_each(links, mass);
        row.add_each(links, [&](int i) { return mass(i) * lengths[i] * lengths[i] / 12; });
        row.add(S(base_t<S>(density)));
    }
    /// A value for every column that a law can have.
    static double water_value(std::string_view column, int i) {
        const double area = lengths[i] * heights[i];
        const std::pair<std::string_view, double> values[] = {
            {"added_mass", 0.1 + 0.1 * i},
            {"friction", 0.02 + 0.01 * i},
            {"drag", 4.0 + i},
            {"friction_area", 2 * area},
            {"drag_area", area},
            {"lateral_area", area},
            {"wetted_area", 2 * area},
            {"added_mass_normal", 1.0},
            {"added_mass_tangential", 0.05},
            {"added_inertia", 1.0},
            {"drag_normal", 1.5},
            {"drag_tangential", 0.01},
            {"linear_normal", 0.5},
            {"linear_tangential", 0.1},
            {"tail_shedding", 0.5},
            {"added_mass_edge", 0.8},
            {"drag_beating", 3.0 - 0.5 * i},
            {"blunt_area", 0.1 * area},
            {"edge_height", 0.12},
            {"edge_aspect", 2.2},
            {"edge_added_mass", 0.8},
            {"edge_lift", 0.6},
            {"edge_suction", 0.7},
        };
        for (const auto& [name, value] : values)
            if (name == column) return value;
        std::abort();  // a new column needs a value here
    }
    static void write_water(ParameterRow<S>& row) {
        for (const WaterColumn& column : Law::columns)
            row.add_each(column.per_link ? links : 1, [&](int i) { return water_value(column.name, i); });
    }

    JointMotion<S> motion_[links];
    LinkShape<S> shape_[2 * steps * links];
    LinkAcceleration<S> acceleration_[2 * steps * links];
    Symmetric<S> mobility_[2 * steps];
    Momentum<S> momentum_[2 * steps];
    S torque_[links], group_power_[links];
    BeatSample<S> sample_[steps];
};

/// Remove the wake of a law that sheds one.
template <class Law>
void stop_shedding(Law& water) {
    if constexpr (requires { water.fin; })
        water.fin = {};
    else if constexpr (requires { water.shedding; })
        water.shedding = 0;
}

/// Numbers in [low, high), the same in every run.
struct Random {
    std::mt19937_64 bits{1};

    double operator()(double low, double high) { return low + (high - low) * std::ldexp(double(bits() >> 11), -53); }
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
