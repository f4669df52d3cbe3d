/// Satellite receiver of u-blox: the message UBX-NAV-PVT, 100 bytes with head and checksum, and the settings that make
/// a receiver of the ninth or tenth generation send it. (Interface descriptions u-blox M9 and M10)
#pragma once

#include <cstdint>
#include <cstring>

namespace hypertuna::firmware {

struct Fix {
    std::int32_t latitude, longitude;  // 1e-7 deg
    std::int32_t accuracy;             // mm
    std::uint8_t satellites;
};

/// Fletcher's checksum of a message, between its two sync bytes and the checksum itself.
inline void sum_message(const std::uint8_t* bytes, int size, std::uint8_t (&sum)[2]) {
    sum[0] = sum[1] = 0;
    for (int k = 2; k < size - 2; ++k) sum[0] = std::uint8_t(sum[0] + bytes[k]), sum[1] = std::uint8_t(sum[1] + sum[0]);
}

struct FixParser {
    static constexpr int size = 100;
    static constexpr std::uint8_t head[6] = {0xb5, 0x62, 0x01, 0x07, 92, 0};

    std::uint8_t bytes[size];
    int count;
    std::uint32_t messages;  // whole ones, with a fix or without

    /// Take a byte; true when a whole message with a good fix in three dimensions is there.
    bool take(std::uint8_t byte, Fix& fix) {
        bytes[count++] = byte;
        while (count > 0 && !begins()) drop();
        if (count < size) return false;
        std::uint8_t sum[2];
        sum_message(bytes, size, sum);
        if (sum[0] != bytes[size - 2] || sum[1] != bytes[size - 1]) {
            do drop();
            while (count > 0 && !begins());
            return false;
        }
        count = 0, ++messages;
        const std::uint8_t* load = bytes + 6;
        const bool good = load[20] == 3 && (load[21] & 1) != 0 && (load[78] & 1) == 0;  // type, valid, not invalid
        fix.satellites = load[23];
        std::memcpy(&fix.longitude, load + 24, 4), std::memcpy(&fix.latitude, load + 28, 4);
        std::memcpy(&fix.accuracy, load + 40, 4);
        if (fix.accuracy < 0) fix.accuracy = INT32_MAX;  // it has 32 bits without a sign
        return good;
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

inline constexpr std::uint32_t receiver_baud = 38'400;

/// UBX-CFG-VALSET into the receiver's RAM: 5 fixes a second by UBX-NAV-PVT alone, dynamic model "sea", 38,400 bit/s.
struct ReceiverSettings {
    static constexpr int size = 6 + 4 + 5 + 5 + 5 + 6 + 5 + 8 + 2;
    std::uint8_t bytes[size];

    ReceiverSettings() {
        const std::uint8_t head[10] = {0xb5, 0x62, 0x06, 0x8a, size - 8, 0, 0, 1, 0, 0};
        std::memcpy(bytes, head, sizeof(head));
        int at = sizeof(head);
        const auto set = [&](std::uint32_t key, std::uint32_t value, int count) {
            for (int k = 0; k < 4; ++k) bytes[at++] = std::uint8_t(key >> 8 * k);
            for (int k = 0; k < count; ++k) bytes[at++] = std::uint8_t(value >> 8 * k);
        };
        set(0x10740001, 1, 1);              // CFG-UART1OUTPROT-UBX
        set(0x10740002, 0, 1);              // CFG-UART1OUTPROT-NMEA
        set(0x20910007, 1, 1);              // CFG-MSGOUT-UBX_NAV_PVT_UART1
        set(0x30210001, 200, 2);            // CFG-RATE-MEAS [ms]
        set(0x20110021, 5, 1);              // CFG-NAVSPG-DYNMODEL: sea
        set(0x40520001, receiver_baud, 4);  // CFG-UART1-BAUDRATE
        std::uint8_t sum[2];
        sum_message(bytes, size, sum);
        bytes[at++] = sum[0], bytes[at++] = sum[1];
    }
};

}  // namespace hypertuna::firmware
