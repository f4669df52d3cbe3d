/// Board teensy41, by the Arduino API alone: analog sensors are sampled every millisecond, IMU, receiver and radio hang
/// on serial ports, the depth sensor on I2C, the store is in the program's flash memory, the black box on the SD card.
#pragma once

#include <Arduino.h>
#include <SD.h>
#include <Servo.h>
#include <Wire.h>

#include "app/app.hpp"
#include "depth.hpp"
#include "imu.hpp"
#include "receiver.hpp"

#ifdef __IMXRT1062__
// Of the core, as its LittleFS_Program uses them: done when they return, with interrupts off meanwhile.
extern "C" void eepromemu_flash_write(void* to, const void* from, std::uint32_t count);
extern "C" void eepromemu_flash_erase_sector(void* sector);
#endif

namespace hypertuna::firmware {

#ifdef __IMXRT1062__
inline std::uint8_t* const flash = reinterpret_cast<std::uint8_t*>(0x607c0000);
#else
inline std::uint8_t* const flash = stand_in::flash;
#endif
inline constexpr std::uint32_t tick_us = 10'000, sample_us = 1'000;
/// The core's emulated EEPROM has 63 sectors at the end of the flash memory, which an upload leaves alone: the store
/// takes some of them instead.
static_assert(flash_sectors <= 63);
inline constexpr int flush_bytes = 32'768;  // of the black box: a second and a half
inline constexpr std::uint8_t depth_address = 0x76;
inline constexpr int depth_reset = 0x1e, depth_pressure = 0x44, depth_temperature = 0x54, depth_memory = 0xa0;

template <class Wiring>
struct Teensy {
    const Wiring& wiring;
    int joints;
    Raw raw;
    std::uint32_t due, sampled;  // us: end of the tick, last samples
    Servo servo[max_servos];
    HardwareSerial *imu, *receiver, *radio;
    ImuParser imu_frames;
    FixParser fixes;
    DepthSensor depth;
    int phase;  // of the depth sensor's conversions, in ms since the tick began
    File box;
    int unflushed;  // bytes that the card does not know of yet

    void begin() {
        HardwareSerial* const ports[] = {&Serial1, &Serial2, &Serial3, &Serial4,
                                         &Serial5, &Serial6, &Serial7, &Serial8};
        imu = ports[wiring.imu_serial - 1], receiver = ports[wiring.position_serial - 1];
        radio = ports[wiring.radio_serial - 1];
        imu->begin(115200), receiver->begin(38400), radio->begin(std::uint32_t(wiring.radio_baud));
        analogReadResolution(12);
        pinMode(std::uint8_t(wiring.leak[0]), INPUT_PULLUP);
        Wire.begin();
        Wire.setClock(400'000);
        begin_depth();
        box = SD.begin(BUILTIN_SDCARD) ? SD.open(free_name(), FILE_WRITE) : File{};
        begin_watchdog();
        due = sampled = micros();
    }

    bool wait() {
        while (std::int32_t(micros() - due) < 0) work();
        // A tick that came too late is not made up for.
        due = std::int32_t(micros() - due) < std::int32_t(tick_us) ? due + tick_us : std::uint32_t(micros()) + tick_us;
        phase = 0;
        return true;
    }
    void read(Raw& to) {
        raw.leak = digitalRead(std::uint8_t(wiring.leak[0])) == LOW;
        to = raw;
        std::memset(static_cast<void*>(&raw), 0, sizeof(raw));
    }
    void drive(const float (&pulse)[max_servos], int count) {
        for (int k = 0; k < count; ++k) {
            if (wiring.servo[k] < 0) continue;  // a joint with a servo on its axle has no second one
            const bool on = 0.0f < pulse[k];
            if (on && !servo[k].attached()) servo[k].attach(wiring.servo[k]);
            if (on) servo[k].writeMicroseconds(int(pulse[k] * 1e6f + 0.5f));
            if (!on && servo[k].attached()) servo[k].detach();
        }
    }
    std::uint32_t clock() { return std::uint32_t(micros()); }
    std::uint32_t per_tick() { return tick_us; }
    void load(int at, std::uint8_t* to, int count) { std::memcpy(to, flash + at, std::size_t(count)); }
    void program(int at, const std::uint8_t* from, int count) {
        eepromemu_flash_write(flash + at, from, std::uint32_t(count));
    }
    /// Interrupts are off for 45 ms, by the data sheet for 0.4 s at most: the watchdog is fed before and after.
    void erase(int sector) { feed(), eepromemu_flash_erase_sector(flash + sector * flash_sector), feed(); }
    bool recovers() { return false; }
    /// The card's directory learns by a flush how long the file is: without it, nothing is left when the power goes.
    int log(const std::uint8_t* from, int count) {
        const int taken = box ? int(box.write(from, std::size_t(count))) : 0;
        unflushed += taken;
        if (unflushed >= flush_bytes) box.flush(), unflushed = 0;
        return taken;
    }
    int receive(std::uint8_t* to, int limit) {
        int count = 0;
        while (count < limit && radio->available() > 0) to[count++] = std::uint8_t(radio->read());
        return count;
    }
    int send(const std::uint8_t* from, int count) {
        const int room = radio->availableForWrite(), fits = count < room ? count : room;
        return fits > 0 ? int(radio->write(from, std::size_t(fits))) : 0;
    }

#ifdef __IMXRT1062__  // the watchdog of the i.MX RT1060 (reference manual, chapter WDOG1-2)
    void begin_watchdog() {
        const int halves = int(2.0f * wiring.watchdog);  // its time-out counts half seconds, from one on
        WDOG1_WMCR = 0;
        WDOG1_WCR = std::uint16_t((halves > 1 ? halves - 1 : 0) << 8 | 0x37);  // on, but not while asleep or debugged
    }
    void feed() { WDOG1_WSR = 0x5555, WDOG1_WSR = 0xaaaa; }
    bool watchdog_reset() { return (WDOG1_WRSR & 2) != 0; }
#else
    void begin_watchdog() {}
    void feed() {}
    bool watchdog_reset() { return false; }
#endif

  private:
    /// Work between two ticks.
    void work() {
        take_imu();
        Fix fix;
        for (int k = 0; k < 64 && receiver->available() > 0; ++k)
            if (fixes.take(std::uint8_t(receiver->read()), fix))
                raw.fix[0] = fix.latitude, raw.fix[1] = fix.longitude, raw.fixed = true, raw.accuracy = fix.accuracy,
                raw.satellites = fix.satellites;
        const std::uint32_t since = std::uint32_t(micros()) - sampled;
        if (since < sample_us) return;
        sampled += since < 2 * sample_us ? sample_us : since;  // what was missed is not made up for
        const auto sample = [&](int channel, int pin) { raw.channel[channel].add(analogRead(std::uint8_t(pin)) << 4); };
        const int* pin = wiring.analog;
        visit_channels([&](const auto& channel, int first) {
            if (channel.converter != Converter::analog) return;
            for (int k = 0; k < channel.count(joints); ++k, ++pin)
                if (0 <= *pin) sample(first + k, *pin);
        });
        convert_depth(phase++);
    }
    void take_imu() {
        ImuFrame frame;
        for (int k = 0; k < 64 && imu->available() > 0; ++k) {
            if (!imu_frames.take(std::uint8_t(imu->read()), frame)) continue;
            const int first = frame.kind == ImuKind::rate           ? first_channel("rate")
                              : frame.kind == ImuKind::acceleration ? first_channel("acceleration")
                                                                    : first_channel("field");
            for (int axis = 0; axis < 3; ++axis) raw.channel[first + axis].add(frame.value[axis]);
        }
    }
    /// Pressure, then temperature, each 3 ms after it was begun: a reading per tick.
    void convert_depth(int ms) {
        if (ms == 0) ask_depth(depth_pressure);
        if (ms == 3) {
            const std::uint32_t pressure = depth_number(0, 3);
            if (pressure != 0 && depth.c[1] != 0) raw.channel[first_channel("depth")].add(depth.pressure(pressure));
            ask_depth(depth_temperature);
        }
        if (ms == 6)
            if (const std::uint32_t temperature = depth_number(0, 3); temperature != 0) depth.temperature(temperature);
    }
    void begin_depth() {
        ask_depth(depth_reset);
        delay(10);
        for (int k = 0; k < 7; ++k) depth.c[k] = std::uint16_t(depth_number(depth_memory + 2 * k, 2));
        depth.dt = 0;
    }
    void ask_depth(int command) {
        Wire.beginTransmission(depth_address);
        Wire.write(std::uint8_t(command));
        Wire.endTransmission();
    }
    /// 0 where the sensor does not answer.
    std::uint32_t depth_number(int command, int bytes) {
        ask_depth(command);
        std::uint32_t number = 0;
        if (Wire.requestFrom(depth_address, std::uint8_t(bytes)) != bytes) return 0;
        for (int k = 0; k < bytes; ++k) number = number << 8 | std::uint8_t(Wire.read());
        return number;
    }
    /// First name of box000.bin to box999.bin that is not on the card.
    static const char* free_name() {
        static char name[] = "box000.bin";
        for (int k = 0; k < 1000; ++k) {
            name[3] = char('0' + k / 100), name[4] = char('0' + k / 10 % 10), name[5] = char('0' + k % 10);
            if (!SD.exists(name)) break;
        }
        return name;
    }
};

}  // namespace hypertuna::firmware
