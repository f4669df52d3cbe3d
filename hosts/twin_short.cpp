/// Twins with the shortest tail, which HyperTuna has; built for speed.
#include "live.hpp"

template struct hypertuna::Twins<hypertuna::short_tail>;
