/// Board teensy41, by the Arduino API and the processor's registers: analog sensors are sampled every millisecond; IMU,
/// receiver and radio hang on serial ports, the depth sensor on I2C; the store is in the program's flash memory, the
/// black box on the SD card.
#pragma once

#include <Arduino.h>

#include "app/app.hpp"
#include "card.hpp"
#include "depth.hpp"
#include "device.hpp"
#include "imu.hpp"
#include "receiver.hpp"
#include "servos.hpp"

// Functions of the core, which its LittleFS_Program uses: done when they return, with interrupts off meanwhile.
extern "C" void eepromemu_flash_write(void* to, const void* from, std::uint32_t count);
extern "C" void eepromemu_flash_erase_sector(void* sector);

namespace hypertuna::firmware {

inline constexpr std::uint32_t tick_us = 10'000, sample_us = 1'000;

/// The core's emulated EEPROM has 63 sectors at the end of the flash memory, which an upload leaves alone: the store
/// takes some of them instead.
static_assert(flash_sectors <= 63);
#ifdef __IMXRT1062__
inline std::uint8_t* const flash = reinterpret_cast<std::uint8_t*>(0x607c0000);
#else
inline std::uint8_t* const flash = stand_in::flash;
#endif

/// Memory in addition to the core's rings of 64 bytes: at 115,200 bit/s these overflow in 6 ms, all of it in 94 ms.
struct Rings {
    std::uint8_t imu[1024], receiver[1024], radio[1024], to_receiver[256], to_radio[512];
};

template <class Wiring>
struct Teensy {
    const Wiring& wiring;
    int joints;
    Raw raw{};
    std::uint32_t due = 0, sampled = 0;  // us: end of the tick, time of the last samples
    HardwareSerialIMXRT *imu = nullptr, *receiver = nullptr, *radio = nullptr;
    ImuParser imu_frames{};
    FixParser fixes{};
    Device imu_device{imu_baud, 1'000'000}, receiver_device{receiver_baud, 5'000'000};  // us
    DepthLine depth{};
    int phase = 0;  // ms since the tick began
    Card card{};
    Rings rings{};

    void begin() {
        analogReadResolution(12);
        for (int pin : {wiring.leak[0], wiring.recovery[0]}) pinMode(std::uint8_t(pin), INPUT_PULLUP);
        for (int pin : wiring.servo)
            if (0 <= pin) begin_servo(pin);
        SNVS_LPCR |= 1 << 24;  // allow access to the words that are kept over a reset
        begin_ports();
        depth.begin();
        card.begin();
        begin_watchdog();
        due = sampled = std::uint32_t(micros());
    }

    bool wait() {
        do work();
        while (std::int32_t(micros() - due) < 0);
        // A tick that came too late is skipped.
        due = std::int32_t(micros() - due) < std::int32_t(tick_us) ? due + tick_us : std::uint32_t(micros()) + tick_us;
        phase = 0;
        return true;
    }
    void read(Raw& to) {
        raw.leak = digitalRead(std::uint8_t(wiring.leak[0])) == LOW;
        to = raw;
        std::memset(static_cast<void*>(&raw), 0, sizeof(raw));
    }
    /// Send the servos' pulses. A joint with a servo on its axle has no second one.
    void drive(const float (&pulse)[max_servos], int count) {
        for (int k = 0; k < count; ++k)
            if (0 <= wiring.servo[k]) send_pulse(wiring.servo[k], pulse[k]);
    }
    /// Count of processor cycles, which goes on while interrupts are off, while micros() stops.
    std::uint32_t clock() { return ARM_DWT_CYCCNT; }
    std::uint32_t per_tick() { return std::uint32_t(F_CPU_ACTUAL) / 1'000'000 * tick_us; }

    void load(int at, std::uint8_t* to, int count) { std::memcpy(to, flash + at, std::size_t(count)); }
    void program(int at, const std::uint8_t* from, int count) {
        eepromemu_flash_write(flash + at, from, std::uint32_t(count));
    }
    /// Erase a sector, which takes 45 ms, by the data sheet at most 0.4 s: the watchdog is fed before and after.
    void erase(int sector) { feed(), eepromemu_flash_erase_sector(flash + sector * flash_sector), feed(); }
    bool recovers() { return digitalRead(std::uint8_t(wiring.recovery[0])) == LOW; }

    /// Keep a word in two registers of the power domain that a reset leaves alone and a coin cell supplies: the second
    /// one checks the first.
    void keep(std::uint32_t word) {
        if (kept() == word) return;
        SNVS_LPGPR0 = word;
        SNVS_LPGPR1 = ~word;
    }
    std::uint32_t kept() { return SNVS_LPGPR1 == ~std::uint32_t(SNVS_LPGPR0) ? std::uint32_t(SNVS_LPGPR0) : 0; }

    int log(const std::uint8_t* from, int count) { return card.write(from, count); }
    int receive(std::uint8_t* to, int limit) {
        int count = 0;
        while (count < limit && radio->available() > 0) to[count++] = std::uint8_t(radio->read());
        return count;
    }
    int send(const std::uint8_t* from, int count) {
        const int space = radio->availableForWrite(), fits = count < space ? count : space;
        return fits > 0 ? int(radio->write(from, std::size_t(fits))) : 0;
    }

    /// Watchdog of the i.MX RT1060 (reference manual, chapter WDOG1-2): its time-out counts half seconds, from one on.
    void begin_watchdog() {
        const int halves = int(2.0f * wiring.watchdog);
        CCM_CCGR3 |= 3 << 16;  // clock of the watchdog
        WDOG1_WMCR = 0;
        WDOG1_WCR = std::uint16_t((halves > 1 ? halves - 1 : 0) << 8 | 0x37);  // on, but not while asleep or debugged
    }
    void feed() {
        WDOG1_WSR = 0x5555;
        WDOG1_WSR = 0xaaaa;
    }
    bool watchdog_reset() { return (WDOG1_WRSR & 2) != 0; }

  private:
    void begin_ports() {
        HardwareSerialIMXRT* const ports[] = {&Serial1, &Serial2, &Serial3, &Serial4,
                                              &Serial5, &Serial6, &Serial7, &Serial8};
        imu = ports[wiring.imu_serial - 1], receiver = ports[wiring.position_serial - 1];
        radio = ports[wiring.radio_serial - 1];
        imu->addMemoryForRead(rings.imu, sizeof(rings.imu));
        receiver->addMemoryForRead(rings.receiver, sizeof(rings.receiver));
        receiver->addMemoryForWrite(rings.to_receiver, sizeof(rings.to_receiver));
        radio->addMemoryForRead(rings.radio, sizeof(rings.radio));
        radio->addMemoryForWrite(rings.to_radio, sizeof(rings.to_radio));
        imu->begin(imu_baud), receiver->begin(receiver_baud), radio->begin(std::uint32_t(wiring.radio_baud));
    }

    /// Work between two ticks.
    void work() {
        take_imu(), take_fixes();
        const std::uint32_t since = std::uint32_t(micros()) - sampled;
        if (since < sample_us) return;
        sampled += since < 2 * sample_us ? sample_us : since;  // missed samples are not made up for
        const auto sample = [&](int channel, int pin) { raw.channel[channel].add(analogRead(std::uint8_t(pin)) << 4); };
        const int* pin = wiring.analog;
        visit_channels([&](const auto& channel, int first) {
            if (channel.converter != Converter::analog) return;
            for (int k = 0; k < channel.count(joints); ++k, ++pin)
                if (0 <= *pin) sample(first + k, *pin);
        });
        depth.work(phase++, raw.channel[first_channel("depth")]);
    }
    void take_imu() {
        imu_device.look(*imu, imu_frames.frames, [&](bool slow) {
            slow ? imu->write(imu_fast, sizeof(imu_fast)) : imu->write(imu_settings, sizeof(imu_settings));
        });
        ImuFrame frame;
        for (int k = 0; k < 64 && imu->available() > 0; ++k) {
            if (!imu_frames.take(std::uint8_t(imu->read()), frame)) continue;
            const int first = frame.kind == ImuKind::rate           ? first_channel("rate")
                              : frame.kind == ImuKind::acceleration ? first_channel("acceleration")
                                                                    : first_channel("field");
            for (int axis = 0; axis < 3; ++axis) raw.channel[first + axis].add(frame.value[axis]);
        }
    }
    void take_fixes() {
        receiver_device.look(*receiver, fixes.messages, [&](bool) {
            const ReceiverSettings settings(wiring.fix_ms);
            receiver->write(settings.bytes, std::size_t(settings.size));
        });
        Fix fix;
        for (int k = 0; k < 64 && receiver->available() > 0; ++k)
            if (fixes.take(std::uint8_t(receiver->read()), fix)) {
                raw.fix[0] = fix.latitude, raw.fix[1] = fix.longitude, raw.fixed = true;
                raw.accuracy = fix.accuracy, raw.satellites = fix.satellites;
            }
    }
};

}  // namespace hypertuna::firmware
