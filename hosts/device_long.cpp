/// Devices with the longer tail: few robots have one; built for size.
#include "device.hpp"

template struct hypertuna::Devices<hypertuna::max_coordinates>;
