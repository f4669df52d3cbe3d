#pragma once

struct Servo {
    int pin = -1, pulse = 0;

    void attach(int to) { pin = to; }
    void detach() { pin = -1; }
    bool attached() { return pin >= 0; }
    void writeMicroseconds(int us) { pulse = us; }
};
