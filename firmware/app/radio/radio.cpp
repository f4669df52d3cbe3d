#include "app/radio/radio.hpp"

#include "app/radio/link.hpp"

namespace hypertuna::firmware {

void begin_radio(Link& link, const Vehicle& vehicle) { boot(link, vehicle); }

void work_radio(Link& link, Vehicle& vehicle, const std::uint8_t* bytes, int count) {
    tick(link, vehicle, bytes, count);
}

}  // namespace hypertuna::firmware
