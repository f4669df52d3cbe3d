/// Board teensy41: the firmware as an Arduino sketch. Not tried on the hardware yet (docs/firmware.md).
#include "teensy.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

static App app;
static Teensy<decltype(robot::wiring)> board{
    robot::wiring, robot::description.joints, {}, 0, 0, {}, nullptr, nullptr, nullptr, {}, {}, {}, 0, {}};

void setup() {
    board.begin();
    boot(app, robot::description, board);
}

void loop() {
    board.wait();
    tick(app, board);
}
