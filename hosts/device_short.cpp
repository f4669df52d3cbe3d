/// Devices with the shortest tail, which most robots have; built for speed.
#include "device.hpp"

template struct hypertuna::Devices<hypertuna::short_tail>;
