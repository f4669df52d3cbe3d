/// Twins with the shorter tail, HyperTuna's among them: built for speed.
#include "live.hpp"

template struct hypertuna::Twins<hypertuna::short_tail>;
