/// Radio: the link as the app calls it. Its code is compiled apart, for size; the controller's is for speed.
#pragma once

#include "app/radio/link_state.hpp"

namespace hypertuna::firmware {

void begin_radio(Link& link, const Vehicle& vehicle);
void work_radio(Link& link, Vehicle& vehicle, const std::uint8_t* bytes, int count);

}  // namespace hypertuna::firmware
