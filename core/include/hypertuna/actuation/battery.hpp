/// Battery: an open-circuit voltage linear in the charge, an internal resistance, and a step-down converter.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Battery {
    S charge;       // C, of the full battery
    S full;         // V, open circuit at full charge
    S empty;        // V, open circuit without charge
    S resistance;   // ohm of the whole battery
    S converter;    // V at the servos, which the converter holds while the battery has more
    S efficiency;   // efficiency of the converter, 0 to 1
    S electronics;  // W that board, sensors and radio draw beside the converter
};

/// Voltages and current of battery and converter at one instant.
template <class S>
struct BatteryOutput {
    S voltage;  // V at the battery's terminals
    S current;  // A from the battery
    S supply;   // V at the servos
};

/// Output while the servos draw a power [W] after the charge `taken` [C]: V = V0 - R I with V I = power / efficiency +
/// electronics.
///
/// A battery that cannot give this power gives the most it can, at half its open-circuit voltage.
template <class S>
BatteryOutput<S> battery_output(const Battery<S>& battery, const S& taken, const S& power) {
    const S charge_left = max(S(0), S(1) - taken / battery.charge);
    const S open = battery.empty + (battery.full - battery.empty) * charge_left,
            wanted = power / battery.efficiency + battery.electronics;
    const S root = sqrt(max(S(0), open * open - S(4) * battery.resistance * wanted));
    const S voltage = (open + root) / S(2);
    const S current = select(S(0) < root, wanted / voltage, open / (S(2) * battery.resistance));
    return {voltage, current, min(battery.converter, voltage)};
}

/// Order of a battery's numbers in a row from Python.
inline constexpr const char* battery_columns[] = {"charge",    "full",       "empty",      "resistance",
                                                  "converter", "efficiency", "electronics"};
inline constexpr int battery_column_count = sizeof(battery_columns) / sizeof(battery_columns[0]);

template <class S, class T>
Battery<S> read_battery(const T* row) {
    return read_row<Battery<S>, S>(battery_columns, row);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
