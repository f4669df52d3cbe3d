/// Twins with the longer tails: few robots have one; built for size.
#include "live.hpp"

template struct hypertuna::Twins<hypertuna::exact_tail>;
template struct hypertuna::Twins<hypertuna::max_coordinates>;
