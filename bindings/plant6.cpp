/// The plant in space, compiled once.
#include "plant6.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {
HYPERTUNA_WATER_LAWS(HYPERTUNA_PLANT6_HERE)
}  // namespace hypertuna::inline HYPERTUNA_ARCH
