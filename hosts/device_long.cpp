/// Devices with the longer tails, which few robots have; built for size.
#include "device.hpp"

template struct hypertuna::Devices<hypertuna::exact_tail>;
template struct hypertuna::Devices<hypertuna::max_coordinates>;
