/// Readings of everything that the pilot steers by: those of the robot, and depth, magnetic field and satellite fixes.
#pragma once

#include "hypertuna/control/controller.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct PilotReadings {
    Readings<T> robot;
    T depth;     // m of the nose below the surface
    T field[3];  // magnetic field in body axes, in units of the field's strength
    T fix[2];    // m east and north, of the satellite receiver
    bool fixed;  // a fix came in this tick
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
