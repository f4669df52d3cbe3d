/// Twins with the longer tails, which few robots have; built for size.
#include "live.hpp"

template struct hypertuna::Twins<hypertuna::exact_tail>;
template struct hypertuna::Twins<hypertuna::max_coordinates>;
