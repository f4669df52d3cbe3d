/// Battery: open-circuit voltage that falls straight with the charge, inner resistance, a step-down converter.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Battery {
    S charge;       // C, full
    S full;         // V, open circuit at full charge
    S empty;        // V, open circuit without charge
    S resistance;   // ohm of the whole battery
    S converter;    // V that the converter holds for the servos as long as the battery has more
    S efficiency;   // of the converter
    S electronics;  // W that board, sensors and radio draw beside the converter
};

/// What battery and converter show at one instant.
template <class S>
struct BatteryOutput {
    S voltage;  // V at the battery's terminals
    S current;  // A from the battery
    S supply;   // V at the servos
};

/// A power drawn by the servos after a charge was taken, C: V = V0 - R I with V I = power / efficiency + electronics.
///
/// A battery that cannot give that much gives the most it can, at half its open-circuit voltage.
template <class S>
BatteryOutput<S> battery_output(const Battery<S>& battery, const S& taken, const S& power) {
    const S left = max(S(0), S(1) - taken / battery.charge);
    const S open = battery.empty + (battery.full - battery.empty) * left,
            wanted = power / battery.efficiency + battery.electronics;
    const S root = sqrt(max(S(0), open * open - S(4) * battery.resistance * wanted));
    const S voltage = (open + root) / S(2);
    const S given = select(S(0) < root, wanted / voltage, open / (S(2) * battery.resistance));
    return {voltage, given, min(battery.converter, voltage)};
}

/// A battery as a row of numbers, in this order: how it comes from Python.
inline constexpr const char* battery_columns[] = {"charge",    "full",       "empty",      "resistance",
                                                  "converter", "efficiency", "electronics"};
inline constexpr int battery_column_count = sizeof(battery_columns) / sizeof(battery_columns[0]);

template <class S, class T>
Battery<S> read_battery(const T* row) {
    return read_row<Battery<S>, S>(battery_columns, row);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
