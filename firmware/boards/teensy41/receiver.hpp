/// Satellite receiver of u-blox: the message UBX-NAV-PVT, 100 bytes with head and checksum.
#pragma once

#include <cstdint>
#include <cstring>

namespace hypertuna::firmware {

struct Fix {
    std::int32_t latitude, longitude;  // 1e-7 deg
    std::int32_t accuracy;             // mm, standard deviation
    std::uint8_t satellites;
};

struct FixParser {
    static constexpr int size = 100;
    static constexpr std::uint8_t head[6] = {0xb5, 0x62, 0x01, 0x07, 92, 0};

    std::uint8_t bytes[size];
    int count;

    /// Take a byte; true when a whole message with a fix in three dimensions is there.
    bool take(std::uint8_t byte, Fix& fix) {
        bytes[count++] = byte;
        while (count > 0 && !begins()) drop();
        if (count < size) return false;
        std::uint8_t a = 0, b = 0;  // Fletcher's checksum over all but head and itself
        for (int k = 2; k < size - 2; ++k) a = std::uint8_t(a + bytes[k]), b = std::uint8_t(b + a);
        if (a != bytes[size - 2] || b != bytes[size - 1]) {
            do drop();
            while (count > 0 && !begins());
            return false;
        }
        count = 0;
        const bool valid = bytes[6 + 20] == 3 && (bytes[6 + 21] & 1) != 0;
        std::memcpy(&fix.longitude, bytes + 6 + 24, 4), std::memcpy(&fix.latitude, bytes + 6 + 28, 4);
        std::memcpy(&fix.accuracy, bytes + 6 + 40, 4), fix.satellites = bytes[6 + 23];
        return valid;
    }

  private:
    bool begins() const {
        for (int k = 0; k < count && k < 6; ++k)
            if (bytes[k] != head[k]) return false;
        return true;
    }
    void drop() {
        --count;
        for (int k = 0; k < count; ++k) bytes[k] = bytes[k + 1];
    }
};

}  // namespace hypertuna::firmware
