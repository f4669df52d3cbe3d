/// Ranges of the numbers of a robot image, on which its readers rely.
///
/// They exclude values that no robot has, so that nothing overflows; the loaders check whether numbers fit together.
/// Counts and indices that size memory are checked where they are read (`whole` of host/columns.hpp).
#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

#include "hypertuna/control/safety.hpp"

namespace hypertuna {

/// Range of the columns whose names end with one of `names`, which are separated by spaces. A finite number is at most
/// `huge`.
struct NumberRange {
    double low, high;
    bool whole;
    std::string_view names;
};

inline constexpr double tiny = 1e-18, huge = 1e18, endless = HUGE_VAL;

/// The first range that names a column applies to it. The last one is for all others: amounts, none of them negative.
inline constexpr NumberRange number_ranges[] = {
    {0, 1, true, "stay tail_shedding cross_flow"},
    {0, 1e3, false, "direct"},
    {1, 1e6, true, "timeout every"},
    {0, 1e4, true, "units"},
    {0, 4294967295., true, "scatter.hash"},
    {-1e6, 1e6, true, "joint_group"},
    {0, 1, false, "efficiency relax couple servo_decay smoothing_decay learning reserve"},
    {-10, 10, false, "share joint_share phase_offset lag neutral declination fin.stall"},
    {1e-5, 1, false, "tick period"},
    {0.01, 1e5, false, "frequency_max"},
    {0.1, 1e6, false, "density"},
    {0, endless, false, "bottom"},
    {tiny, endless, false, "converter pulse_per_rad"},
    {0, huge, false, "circuit.bandwidth circuit.inertia joint.length"},  // zeros where a servo moves the joint
    {1e-3, endless, false, "bandwidth"},
    {tiny, huge, false, "length mass inertia body_length robot_mass"},
    {-1e9, 1e9, false,
     "rest com com_height center center_height low map map_low map_high pressure_low current_low current_east "
     "current_north shear_east shear_north field_east field_north field_up tide_east tide_north gust_east gust_north "
     "cavitation depth_low air_low air_high antenna antenna_x antenna_z fin.x fin.y fin.z pose start home waypoints "
     "fence high bias moment_phase"},
    {-huge, huge, false, "controller.hold"},
    {0, huge, false, ""},
};

/// Whether a column's name is one of a list, or ends with one behind a dot.
constexpr bool is_listed(std::string_view column, std::string_view names) {
    while (!names.empty()) {
        const std::size_t end = names.find(' ');
        const std::string_view name = names.substr(0, end);
        const std::size_t before = column.size() - name.size();
        if (column.ends_with(name) && (before == 0 || column[before - 1] == '.')) return true;
        names.remove_prefix(end == names.npos ? names.size() : end + 1);
    }
    return false;
}

constexpr const NumberRange& range_of(std::string_view column) {
    const NumberRange* range = number_ranges;
    while (!range->names.empty() && !is_listed(column, range->names)) ++range;
    return *range;
}

constexpr bool in_range(const NumberRange& range, double number) {
    return range.low <= number && number <= range.high && (number <= huge || number == endless) &&
           (!range.whole || number == double(std::int64_t(number)));
}

/// What is wrong with a number, as a sentence.
inline std::string out_of_range(std::string_view column, const NumberRange& range, double number) {
    char text[160];
    std::snprintf(text, sizeof(text), ": must be %s from %g to %g, but is %g; write the image again",
                  range.whole ? "a whole number" : "a number", range.low, range.high, number);
    return std::string("image: ").append(column) + text;
}

}  // namespace hypertuna
