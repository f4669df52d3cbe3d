/// A policy alone on the emulated Cortex-M7: observations come in, actions, commands and counts of the clock go out.
#include "hypertuna/control/policy.hpp"

#include "semihosting.hpp"
#include HYPERTUNA_POLICY

using namespace hypertuna;
using namespace hypertuna::firmware;

static volatile std::uint32_t& at(std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); }

int main() {
    at(0xe000e014) = 0x00ffffff;  // SysTick: 24 bits down, at the processor's clock
    at(0xe000e018) = 0;
    at(0xe000e010) = 5;
    const int in = semihosting::open("observations", 12, semihosting::Access::read);
    const int out = semihosting::open("actions", 7, semihosting::Access::write);
    if (in < 0 || out < 0) return 72;
    float observation[max_neurons], action[max_neurons];
    const std::size_t size = sizeof(float) * std::size_t(policy.layer[0].inputs);
    while (semihosting::read(in, observation, size) == 0) {
        const std::uint32_t before = at(0xe000e018);
        act(policy, observation, action);
        const Command<float> command = command_of(policy, action);
        const std::uint32_t count = (before - at(0xe000e018)) & 0xffffff;
        semihosting::write(out, action, sizeof(float) * std::size_t(policy.layer[policy.layers - 1].outputs));
        semihosting::write(out, &command.frequency, sizeof(float));
        for (const float* row : {command.amplitude, command.phase, command.bias})
            semihosting::write(out, row, sizeof(float) * std::size_t(policy.joints));
        semihosting::write(out, &count, sizeof(count));
    }
    return 0;
}
