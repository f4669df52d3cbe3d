/// Tests of the oil's flow: viscosity from pressures, and the largest rate of a pump.
#include <cmath>

#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

/// The viscosity is found from the pressures that it causes, in spite of a load out of phase.
static void the_viscosity_is_learned() {
    for (double truth : {1.0, 0.3, 0.02}) {
        Viscosity<double> oil{};
        for (int i = 0; i < 400; ++i) {
            const double turned = std::cos(0.2 * i), load = 2e4 * std::sin(0.2 * i);
            learn(oil, 3e5 * turned, truth * 3e5 * turned + load);
            weigh(oil, 0.005, 0.1);
        }
        CHECK_NEAR(oil.value, truth, 0.02);
        CHECK(oil.value <= oil.largest && oil.largest <= 1);
        CHECK(oil.rate == (truth < 0.05 ? 1 - flow_undamped : 1));  // thin oil allows a slower pump only
    }
    Viscosity<double> unknown{};
    weigh(unknown, 0.005, 0.1);
    CHECK(unknown.value == 1);  // before any reading the oil counts as thick as it gets
}

/// A critically damped servo that is sent to the furthest target turns by exactly the desired angle within the tick.
static void the_furthest_target_by_the_filter() {
    const Smoothing<double> servo = test_controller<double>().servo;
    for (double before : {0.0, 0.01, -0.02})
        for (double change : {0.0, 0.005, 0.03}) {
            const Follower<double> now{0.1, before};
            CHECK_NEAR(follow(servo, now, furthest_target(servo, now, change)).change, change, 1e-15);
        }
}

/// Thick oil: pressure drop of the line; thin oil: hammer. Both add like two sides of a right angle.
static void pressure_per_rate_by_hand() {
    SupervisorModel<double> circuit{};
    circuit.line = 3e5, circuit.hammer = 4e4;
    CHECK_NEAR(pressure_per_rate(circuit, 0.1), 5e4, 1e-9);
    CHECK_NEAR(pressure_per_rate(circuit, 0.0), 4e4, 1e-9);
}

int main() {
    the_viscosity_is_learned();
    the_furthest_target_by_the_filter();
    pressure_per_rate_by_hand();
    return failures();
}
