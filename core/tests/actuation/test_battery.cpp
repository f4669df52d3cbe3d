/// Tests of the battery: sag by hand, the charge that is left, its largest power, and the voltage at the servos.
#include "check.hpp"
#include "hypertuna/actuation/battery.hpp"

using namespace hypertuna;

static Battery<double> battery() { return {12600.0, 16.8, 12.0, 0.2, 7.4, 0.9, 0.0}; }

int main() {
    const Battery<double> b = battery();
    // 22.5 W at the servos are 25 W before the converter: V (16.8 - V) / 0.2 = 25.
    const BatteryOutput<double> swimming = battery_output(b, 0.0, 22.5);
    CHECK_NEAR(swimming.voltage * (16.8 - swimming.voltage), 5.0, 1e-12);
    CHECK_NEAR(swimming.voltage * swimming.current, 25.0, 1e-12);
    CHECK(swimming.voltage > 16 && swimming.supply == 7.4);
    CHECK(battery_output(b, 0.0, 0.0).voltage == 16.8 && battery_output(b, 0.0, 0.0).current == 0.0);
    CHECK_NEAR(battery_output(b, 6300.0, 0.0).voltage, 14.4, 1e-14);
    CHECK(battery_output(b, 12600.0, 0.0).voltage == 12.0 && battery_output(b, 20000.0, 0.0).voltage == 12.0);
    // Most power: half the voltage across the inner resistance, here 42 A and 352.8 W.
    const BatteryOutput<double> shorted = battery_output(b, 0.0, 1e6);
    CHECK_NEAR(shorted.voltage, 8.4, 1e-14);
    CHECK_NEAR(shorted.current, 42.0, 1e-12);
    Battery<double> direct = b;
    direct.converter = 1e9;  // no converter: the servos get the battery's voltage
    CHECK(battery_output(direct, 0.0, 22.5).supply == swimming.voltage);
    Battery<double> ideal = b;
    ideal.resistance = 0.0;
    CHECK_NEAR(battery_output(ideal, 0.0, 22.5).current, 25.0 / 16.8, 1e-14);
    Battery<double> aboard = b;  // 2.5 W of electronics beside the converter, which loses a tenth of its power
    aboard.electronics = 2.5;
    CHECK(battery_output(aboard, 0.0, 20.25).current == swimming.current);
    return failures();
}
