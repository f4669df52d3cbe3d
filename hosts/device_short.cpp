/// Devices with the shorter tail: the most; built for speed.
#include "device.hpp"

template struct hypertuna::Devices<hypertuna::short_tail>;
