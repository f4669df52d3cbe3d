/// The plant in space, compiled once.
#include "plant6.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {
HYPERTUNA_PLANT6()
}  // namespace hypertuna::inline HYPERTUNA_ARCH
