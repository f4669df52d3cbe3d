/// Board teensy41: the firmware as an Arduino sketch. Not tried on the hardware yet (docs/firmware.md).
#include "teensy.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

static App app;
static Teensy<decltype(robot::wiring)> board{robot::wiring, robot::description.joints};
static_assert(Board<decltype(board)>);

constexpr bool all_have_pulses() {
    for (int pin : robot::wiring.servo)
        if (0 <= pin && !has_pulses(pin)) return false;
    return true;
}
static_assert(all_have_pulses(),
              "a servo's pin has no pulses by hardware: choose 0 to 15, 18, 19, 22 to 25, 28, 29, 33, 36 or 37");
constexpr bool is_port(int number) { return 1 <= number && number <= 8; }
static_assert(is_port(robot::wiring.imu_serial) && is_port(robot::wiring.position_serial) &&
                  is_port(robot::wiring.radio_serial) && robot::wiring.imu_serial != robot::wiring.position_serial &&
                  robot::wiring.imu_serial != robot::wiring.radio_serial &&
                  robot::wiring.position_serial != robot::wiring.radio_serial,
              "a Teensy 4.1 has serial ports 1 to 8, each for one line");

void setup() {
    board.begin();
    boot(app, robot::description, board);
}

void loop() {
    board.wait();
    tick(app, board);
}
