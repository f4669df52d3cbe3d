/// Tests of the policy: a network by hand, the gait of an action, and the controller's limits with any weights and
/// observations.
#include <limits>

#include "check.hpp"
#include "hypertuna/control/policy.hpp"
#include "pilot.hpp"

using namespace hypertuna;

/// Six actions of two observations, through a hidden layer of two neurons.
struct Network2 {
    double hidden[4], bias[2], out[12], shift[6];
    Layer<double> layer[2] = {{2, 2, hidden, bias}, {2, 6, out, shift}};
    Policy<double> policy{2, layer, 10, 2, 5.0, {0.4, 0.6}, pi, 0.5};
};

static void a_network_by_hand() {
    Network2 net{{1, 0, 0, 2}, {0, 0.5}, {1, 0, 0, 1, 3, 0, 0, 0, 0.5, 0.5, 0, 0}, {0, 0, 0, -0.25, 0, 1}};
    const double observation[2] = {0.3, -0.1}, a = std::tanh(0.3), b = std::tanh(0.3);
    double action[6];
    act(net.policy, observation, action);
    const double wanted[6] = {a, b, 3 * a, -0.25, 0.5 * (a + b), 1};
    for (int k = 0; k < 6; ++k) CHECK_NEAR(action[k], wanted[k], 1e-15);
    const Command<double> gait = command_of(net.policy, action);
    CHECK_NEAR(gait.frequency, 5 * (1 + a) / 2, 1e-15);
    CHECK_NEAR(gait.amplitude[0], 0.4 * (1 + b) / 2, 1e-15);
    CHECK_NEAR(gait.amplitude[1], 0.6 * (1 + 3 * a) / 2, 1e-15);
    CHECK_NEAR(gait.phase[1], pi * 0.375, 1e-15);
    CHECK_NEAR(gait.bias[0], 0.5 * 0.4 * 0.5 * (a + b), 1e-15);
    CHECK_NEAR(gait.bias[1], 0.5 * 0.6, 1e-15);
    CHECK(gait.fresh && gait.armed);
}

/// Ticks of the controller under a policy; returns the last step. Pulses stay within clamp and slew.
static ControllerStep<double> under(const Network2& net, double spoiled, int from, int ticks) {
    const Controller<double> model = test_controller<double>();
    ControllerStep<double> now{init(model), {}};
    double last[4] = {};
    for (int i = 0; i < ticks; ++i) {
        const Readings<double> readings = tail_readings(now.output, 0.9, i);
        const double observation[2] = {i < from ? readings.bend[0] : spoiled, readings.bend[1]};
        double action[6];
        act(net.policy, observation, action);
        now = step(model, now.state, readings, command_of(net.policy, action));
        for (int s = 0; s < 4; ++s) {
            CHECK(model.pulse_min <= now.output.pulse[s] && now.output.pulse[s] <= model.pulse_max);
            CHECK(std::abs(now.output.target[s] - last[s]) <= 1.0001 * model.slew * model.tick);
            last[s] = now.output.target[s];
        }
    }
    return now;
}

/// With any weights, each amplitude stays within the joint's limit. A NaN is not sent as a command, and the
/// tail comes to rest.
static void behind_the_guard() {
    const Controller<double> model = test_controller<double>();
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Network2 wild{};
        std::uint64_t draw = 0;
        for (double& w : wild.hidden) w = 50 * normal<double>(random_bits(7, seed, draw++));
        for (double& w : wild.out) w = 50 * normal<double>(random_bits(7, seed, draw++));
        const auto now = under(wild, 1e30, 150, 300);
        for (int j = 0; j < 2; ++j) CHECK(now.state.amplitude[j].value <= model.joint[j].amplitude + 1e-12);
    }
    Network2 sound{{1, 0, 0, 1}, {0, 0}, {}, {-0.2, 0, 0, 0, 0, 0}};
    sound.out[2] = 0.1;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(under(sound, nan, 150, 180).state.amplitude[0].value > 0.05);  // the last good command holds
    const auto lost = under(sound, nan, 150, 500);
    CHECK(lost.output.status.has(Condition::timeout));
    CHECK(asked_amplitude(lost.state, 0) < 1e-4);
}

int main() {
    a_network_by_hand();
    behind_the_guard();
    return failures();
}
