/// Board teensy41: the firmware as an Arduino sketch. Not tried on the hardware yet (docs/firmware.md).
#include "teensy.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

static App app;
static Teensy<decltype(robot::wiring)> board{
    robot::wiring, robot::description.joints, {}, 0, 0, {}, nullptr, nullptr, nullptr, {}, {}, {}, 0, {}, 0};

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
