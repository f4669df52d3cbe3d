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
    std::uint32_t messages;  // complete messages, with a fix or without

    /// Take a byte; true when a complete message with a good fix in three dimensions is there.
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
        const bool good = load[20] == 3 && (load[21] & 1) != 0 &&
                          (load[78] & 1) == 0;  // type of the fix, flag "valid", flag "invalid"
        fix.satellites = load[23];
        std::memcpy(&fix.longitude, load + 24, 4), std::memcpy(&fix.latitude, load + 28, 4);
        std::memcpy(&fix.accuracy, load + 40, 4);
        if (fix.accuracy < 0) fix.accuracy = INT32_MAX;  // the receiver's number has 32 bits without a sign
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

/// Settings in the receiver's RAM: UBX-NAV-PVT alone at 38,400 bit/s, the dynamic model "sea", time between fixes.
/// First for the eighth generation, in messages of their own, then for the ninth and tenth; each ignores the other's.
struct ReceiverSettings {
    std::uint8_t bytes[160];
    int size = 0;

    explicit ReceiverSettings(int fix_ms) {
        begin(0x01), put(0x0701, 2), put(1, 1), end();                            // CFG-MSG: NAV-PVT on this port
        begin(0x08), put(fix_ms, 2), put(1, 2), put(1, 2), end();                 // CFG-RATE
        begin(0x24), put(1, 2), put(5, 1), skip(33), end();                       // CFG-NAV5: model "sea" alone
        begin(0x00), put(1, 4), put(0x8d0, 4), put(receiver_baud, 4), put(1, 2);  // CFG-PRT: UART 1, 8N1, UBX in
        put(1, 2), skip(4), end();                                                // UBX out
        begin(0x8a), put(0x100, 4);                                               // CFG-VALSET in RAM
        put(0x10740001, 4), put(1, 1);                                            // CFG-UART1OUTPROT-UBX
        put(0x10740002, 4), put(0, 1);                                            // CFG-UART1OUTPROT-NMEA
        put(0x20910007, 4), put(1, 1);                                            // CFG-MSGOUT-UBX_NAV_PVT_UART1
        put(0x30210001, 4), put(fix_ms, 2);                                       // CFG-RATE-MEAS
        put(0x20110021, 4), put(5, 1);                                            // CFG-NAVSPG-DYNMODEL
        put(0x40520001, 4), put(receiver_baud, 4), end();                         // CFG-UART1-BAUDRATE
    }

  private:
    int from = 0;  // start of the message being made

    void put(std::uint32_t number, int count) {
        for (int k = 0; k < count; ++k) bytes[size++] = std::uint8_t(number >> 8 * k);
    }
    void skip(int count) {
        while (count-- > 0) bytes[size++] = 0;
    }
    void begin(std::uint8_t id) { from = size, put(0x0662b5, 3), put(id, 1), put(0, 2); }
    void end() {
        bytes[from + 4] = std::uint8_t(size - from - 6);
        std::uint8_t sum[2];
        sum_message(bytes + from, size + 2 - from, sum);
        put(sum[0], 1), put(sum[1], 1);
    }
};

}  // namespace hypertuna::firmware
