/// Devices with the longer tails: few robots have one; built for size.
#include "device.hpp"

template struct hypertuna::Devices<hypertuna::exact_tail>;
template struct hypertuna::Devices<hypertuna::max_coordinates>;
