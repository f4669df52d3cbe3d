/// Twins with the longer tail: few robots have one; built for size.
#include "live.hpp"

template struct hypertuna::Twins<hypertuna::max_coordinates>;
