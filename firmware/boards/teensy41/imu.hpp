/// IMU like the JY931: frames of 11 bytes on a serial line: 0x55, kind, four numbers of 16 bits, sum of the bytes
/// before. Its settings are registers; after an unlocking command they are written by 0xff 0xaa, number, two bytes.
#pragma once

#include <cstdint>

namespace hypertuna::firmware {

enum class ImuKind : std::uint8_t { acceleration = 0x51, rate = 0x52, field = 0x54 };

struct ImuFrame {
    ImuKind kind;
    std::int16_t value[3];
};

/// Settings of the IMU: 115,200 bit/s; then acceleration, rate and field, 200 times a second.
inline constexpr std::uint32_t imu_baud = 115'200;
inline constexpr std::uint8_t imu_fast[] = {0xff, 0xaa, 0x69, 0x88, 0xb5, 0xff, 0xaa, 0x04, 0x06, 0};
inline constexpr std::uint8_t imu_settings[] = {0xff, 0xaa, 0x69, 0x88, 0xb5, 0xff, 0xaa, 0x02,
                                                0x16, 0,    0xff, 0xaa, 0x03, 0x0b, 0};

/// Finds frames in a stream of bytes. After a broken frame it finds the next one within the length of a frame.
struct ImuParser {
    std::uint8_t bytes[11];
    int count;
    std::uint32_t frames;  // number of frames of a known kind

    /// Take a byte; true when a complete frame of a known kind is there.
    bool take(std::uint8_t byte, ImuFrame& frame) {
        bytes[count++] = byte;
        while (count > 0 && bytes[0] != 0x55) drop(1);
        if (count < 11) return false;
        std::uint8_t sum = 0;
        for (int k = 0; k < 10; ++k) sum = std::uint8_t(sum + bytes[k]);
        if (sum != bytes[10]) {
            do drop(1);
            while (count > 0 && bytes[0] != 0x55);
            return false;
        }
        frame.kind = ImuKind(bytes[1]);
        for (int k = 0; k < 3; ++k) frame.value[k] = std::int16_t(bytes[2 + 2 * k] | bytes[3 + 2 * k] << 8);
        count = 0;
        const bool known =
            frame.kind == ImuKind::acceleration || frame.kind == ImuKind::rate || frame.kind == ImuKind::field;
        frames += known;
        return known;
    }

  private:
    void drop(int few) {
        count -= few;
        for (int k = 0; k < count; ++k) bytes[k] = bytes[k + few];
    }
};

}  // namespace hypertuna::firmware
