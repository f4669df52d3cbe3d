/// Board teensy41 against a stand-in for the Arduino API: sensors in, servos out, parsers that survive noise.
#include <cmath>
#include <new>

#include "../../../core/tests/check.hpp"
#include "../../boards/teensy41/main.cpp"

using namespace hypertuna;

static constexpr Station ground{255, 190};

static std::uint32_t noise_state = 1;
static std::uint8_t noise() { return std::uint8_t((noise_state = noise_state * 1664525u + 1013904223u) >> 24); }

static void put_imu(HardwareSerialIMXRT& line, std::uint8_t kind, const int (&value)[3]) {
    std::uint8_t bytes[11] = {0x55, kind}, sum = 0;
    for (int k = 0; k < 3; ++k)
        bytes[2 + 2 * k] = std::uint8_t(value[k]), bytes[3 + 2 * k] = std::uint8_t(value[k] >> 8);
    for (int k = 0; k < 10; ++k) sum = std::uint8_t(sum + bytes[k]);
    bytes[10] = sum;
    line.come(bytes, 11);
}

static void put_fix(HardwareSerialIMXRT& line, std::int32_t latitude, std::int32_t longitude, int type = 3,
                    int valid = 1, int invalid = 0) {
    std::uint8_t bytes[100] = {0xb5, 0x62, 1, 7, 92, 0}, sum[2];
    const std::int32_t accuracy = 2500;
    bytes[6 + 20] = std::uint8_t(type), bytes[6 + 21] = std::uint8_t(valid), bytes[6 + 23] = 9;
    bytes[6 + 78] = std::uint8_t(invalid);
    std::memcpy(bytes + 30, &longitude, 4), std::memcpy(bytes + 34, &latitude, 4);
    std::memcpy(bytes + 46, &accuracy, 4);
    sum_message(bytes, 100, sum);
    bytes[98] = sum[0], bytes[99] = sum[1];
    line.come(bytes, 100);
}

/// What the sensors of a robot that floats upright send, with a little noise.
static void float_on(int ticks) {
    const Calibration& c = app.vehicle.model.calibration;
    for (int t = 0; t < ticks; ++t) {
        const auto show = [&](int channel, int pin, float value) {
            stand_in::analog[pin] = int((value / c.scale[channel] + c.zero[channel]) / 16) + noise() % 4;
        };
        const int* pin = robot::wiring.analog;
        for (int j = 0; j < 2; ++j) show(first_channel("bend") + j, *pin++, 0);
        for (int k = 0; k < 4; ++k) show(first_channel("pressure") + k, *pin++, 60e3f);
        for (int k = 0; k < 4; ++k) show(first_channel("current") + k, *pin++, 0.3f);
        show(first_channel("voltage"), *pin++, 15);
        const int small = noise() % 8;
        put_imu(Serial1, 0x51, {small, -small, int(9.81f / c.scale[first_channel("acceleration")])});
        put_imu(Serial1, 0x52, {small, small, -small});
        put_imu(Serial1, 0x54, {small, 11468 + small, -11468});
        if (t % 100 == 0) put_fix(Serial8, 300000000 + t, 1200000000);
        loop();
    }
}

/// The board as it is when its program starts.
static void boot_board() {
    new (&board) Teensy<decltype(robot::wiring)>{robot::wiring, robot::description.joints};
    setup();
}

static void it_boots_and_reads() {
    Serial1.device = imu_baud, Serial8.device = receiver_baud;
    boot_board();
    CHECK(Serial2.rates.back() == 9600 && stand_in::disk.files.count("box000.bin") == 1);
    float_on(200);
    const Snapshot& now = snapshot(app.vehicle);
    CHECK(now.tick == 200);
    CHECK_NEAR(now.readings.robot.pressure[2], 60e3, 700);  // 12 bits: 183 Pa
    CHECK_NEAR(now.readings.robot.acceleration[2], 9.81, 0.01);
    CHECK_NEAR(now.readings.robot.voltage, 15, 0.03);
    // The data sheet's example: 3999.8 mbar, 30.5 m below 1013.25.
    CHECK_NEAR(now.readings.depth, (399980 - 101325) / 9810.0, 0.01);
    CHECK(now.estimate.attitude && origin(app.vehicle).known);
    CHECK(origin(app.vehicle).latitude == 300000000);
    CHECK(app.vehicle.raw.channel[first_channel("bend")].count >= 8);  // a tick has ten samples
    CHECK(stand_in::watchdog.on && stand_in::watchdog.timeout_us == 500'000 && stand_in::watchdog.bites == 0);
    CHECK(Serial1.lost + Serial2.lost + Serial8.lost == 0);
    CHECK(!now.faults.has(firmware::Fault::overrun));
    CHECK(!Serial2.out.empty());  // telemetry
}

/// Pulses come from timers: 50 a second, each within a microsecond of what is asked for, none for 0.
static void it_drives_servos() {
    stand_in::bus.pressure = 4511096;  // 5 cm below an air pressure of 1,013 hPa
    float_on(300);
    const auto pulse = [](int k) { return stand_in::pwm.pulse(robot::wiring.servo[k]); };
    for (int k = 0; k < 6; ++k) CHECK(pulse(k) == 0);
    double worst = 0;
    for (int pin : robot::wiring.servo) {
        CHECK_NEAR(stand_in::pwm.rate(pin), 50, 1e-3);
        for (float us = 500; us <= 2500; us += 0.1f) {
            send_pulse(pin, us * 1e-6f);
            worst = std::max(worst, std::abs(stand_in::pwm.pulse(pin) - double(us)));
        }
        send_pulse(pin, 0);
    }
    CHECK(worst < 0.5);
    CHECK(give(app.vehicle, Order::arm, ground) == Refusal::none);
    Command<float> beat = rest();
    beat.frequency = 2, beat.amplitude[0] = beat.amplitude[1] = 0.25f;
    CHECK(set_gait(app.vehicle, ground, beat) == Refusal::none);
    double low = 9999, high = 0;
    for (int k = 0; k < 300; ++k) {
        on_ground_contact(app.vehicle, ground), float_on(1);
        low = std::min(low, pulse(0)), high = std::max(high, pulse(0));
    }
    CHECK(800 <= low && low < 1490 && 1510 < high && high <= 2200);
    give(app.vehicle, Order::disarm, ground), float_on(300);
    for (int k = 0; k < 6; ++k) CHECK(pulse(k) == 0);
}

static void parameters_survive_a_reset() {
    int k = 0;
    while (std::strcmp(parameter(app.vehicle, k).name, "learning") != 0) ++k;
    CHECK(set_parameter(app.vehicle, ground, k, 0.25f) == Refusal::none);
    float_on(200);
    boot_board();
    CHECK(value(app.vehicle, k) == 0.25f && !app.vehicle.defaults);
}

static void silent_sensors_and_a_leak() {
    stand_in::bus.silent = true;
    Serial1.line.clear(), Serial1.ring.clear();
    stand_in::digital[robot::wiring.leak[0]] = LOW;
    for (int k = 0; k < 150; ++k) loop();
    const Snapshot& now = snapshot(app.vehicle);
    CHECK(now.faults.has(firmware::Fault::imu) && now.faults.has(firmware::Fault::leak) && !now.estimate.depths);
    stand_in::bus.silent = false, stand_in::digital.clear();
    float_on(150);
    CHECK(app.vehicle.raw.channel[first_channel("depth")].count == 1);  // the sensor is back after its pause
}

/// Run for some ticks; return the longest time from one to the next [us].
static std::uint64_t longest_tick(int ticks) {
    std::uint64_t most = 0;
    for (int k = 0; k < ticks; ++k) {
        const std::uint64_t before = stand_in::now_us;
        float_on(1);
        most = std::max(most, stand_in::now_us - before);
    }
    return most;
}

/// A bus that is held low costs one late tick, then nothing but a look a second; it is freed by clock pulses.
static void a_stuck_bus() {
    stand_in::Bus& bus = stand_in::bus;
    const int depth = first_channel("depth");
    boot_board(), float_on(10);
    CHECK(app.vehicle.raw.channel[depth].count == 1);
    bus.broken = true;
    float_on(1);
    const int transfers = bus.transfers;
    const std::uint64_t begin = stand_in::now_us;
    CHECK(longest_tick(1000) < 11'000 && bus.transfers == transfers);
    CHECK(stand_in::now_us - begin < 10'100'000);  // 100 ticks a second
    CHECK(app.vehicle.raw.channel[depth].count == 0);
    bus.broken = false, float_on(150);
    CHECK(app.vehicle.raw.channel[depth].count == 1);
    for (int stop = 0; stop < 5; ++stop) {
        bus.clockless = true;  // the sensor is cut off in the middle of a transfer
        CHECK(longest_tick(1) < 28'000 && bus.held);
        CHECK(longest_tick(150) < 11'000 && !bus.held);
        CHECK(app.vehicle.raw.channel[depth].count == 1);
    }
    bus.blind = true;  // then each look at a stuck bus costs a late tick, once a second
    boot_board(), float_on(50);
    CHECK(app.vehicle.raw.channel[depth].count == 1);
    bus.clockless = true;
    CHECK(longest_tick(1) < 28'000);
    CHECK(longest_tick(150) < 11'000 && app.vehicle.raw.channel[depth].count == 1);
    bus.broken = true, float_on(1);
    CHECK(longest_tick(300) < 11'000 && app.vehicle.raw.channel[depth].count == 0);
    bus.broken = bus.blind = false;
    bus.memory[3] ^= 4;  // read with an error: such a sensor measures nothing
    boot_board(), float_on(50);
    CHECK(app.vehicle.raw.channel[depth].count == 0);
    bus.memory[3] ^= 4;
    float_on(150);
    CHECK(app.vehicle.raw.channel[depth].count == 1);
}

/// The example of the checksum's application note, and compensation to second order against whole numbers of Python.
static void the_depth_sensor_computes() {
    CHECK(DepthSensor::checksum({0x3132, 0x3334, 0x3536, 0x3738, 0x3940, 0x4142, 0x4344, 0x4500}) == 0xb);
    DepthSensor sensor{{0x2000, 34982, 36352, 20328, 22354, 26646, 26146}, 0, 0};
    CHECK(sensor.is_valid());
    const std::uint32_t temperature[4] = {6815414, 6495414, 7135414, 5615414};
    const int celsius[4] = {1981, 984, 2978, -1759}, pressure[4] = {39998, 39489, 40517, 38098};
    for (int k = 0; k < 4; ++k) {
        sensor.temperature(temperature[k]);
        CHECK(sensor.celsius == celsius[k] && sensor.pressure(4958179) == pressure[k]);
    }
    sensor.c[5] ^= 0x100;
    CHECK(!sensor.is_valid());
    sensor = {};
    CHECK(!sensor.is_valid());
}

/// The card has all but the last sectors, whenever the power goes; a slow one delays no tick, and what it has no time
/// for is lost and told. At the next boot the file is cut to what was written.
static void the_black_box_lasts() {
    stand_in::Disk& disk = stand_in::disk;
    disk.files.clear(), disk.sectors.clear();
    boot_board();
    const std::uint32_t waits = disk.waits;
    disk.slow_every = 50, disk.slow_us = 250'000;
    CHECK(longest_tick(1000) < 11'000 && disk.waits == waits);
    CHECK(disk.content("box000.bin").size() > 200'000 && app.vehicle.box.lost == 0);
    CHECK(1000 * 216 - disk.content("box000.bin").size() < 8'192 + 512 + 512);  // of records with 216 bytes
    CHECK(!snapshot(app.vehicle).faults.has(firmware::Fault::black_box));
    disk.slow_us = 900'000;  // longer than the watchdog's time
    CHECK(longest_tick(300) < 11'000 && disk.waits == waits && stand_in::watchdog.bites == 0);
    CHECK(app.vehicle.box.lost > 0 && snapshot(app.vehicle).faults.has(firmware::Fault::black_box));
    disk.slow_every = 0;
    const std::size_t written = disk.content("box000.bin").size();
    boot_board();
    CHECK(disk.files["box000.bin"].second == written && disk.files.count("box001.bin") == 1);
    CHECK(disk.files["box001.bin"].second == box_bytes);
    disk.failing = true, float_on(100);
    CHECK(snapshot(app.vehicle).faults.has(firmware::Fault::black_box) && stand_in::watchdog.bites == 0);
    disk.failing = false;
    for (int which = 0; which < 2; ++which) {  // no card; one whose directory must be kept up to date
        disk.missing = which == 0, disk.fat = which == 1 ? 64 : 32;
        boot_board();
        float_on(100);
        CHECK(snapshot(app.vehicle).faults.has(firmware::Fault::black_box));
    }
    disk.missing = false, disk.fat = 32;
    boot_board();
}

/// Bytes that come during a long tick wait in the rings.
static void rings_hold_a_long_tick() {
    boot_board(), float_on(10);
    const auto burst = [](std::uint32_t stall_us) {
        const std::uint32_t lost = Serial1.lost + Serial8.lost;
        for (int k = 0; k < 12; ++k) put_imu(Serial1, 0x52, {1, 2, 3});
        put_fix(Serial8, 300000000, 1200000000);
        stand_in::pass(stall_us);
        float_on(3);
        return Serial1.lost + Serial8.lost - lost;
    };
    CHECK(burst(60'000) == 0 && Serial1.ring.empty());
}

/// While an erasure takes the longest that the data sheet allows, the watchdog does not bite, and the clock sees it.
static void a_slow_erasure() {
    boot_board(), float_on(100);
    stand_in::erase_us = 400'000;
    int k = 0;
    while (std::strcmp(parameter(app.vehicle, k).name, "learning") != 0) ++k;
    CHECK(set_parameter(app.vehicle, ground, k, 0.5f) == Refusal::none);
    const std::uint32_t before = board.clock(), us = micros();
    float_on(30);
    CHECK(settled(app.vehicle.store) && stand_in::watchdog.bites == 0);
    CHECK(board.clock() - before > 600 * (std::uint32_t(micros()) - us + 390'000));
    stand_in::erase_us = 45'000;
}

/// A word is kept over a reset, and a register with anything else in it is none.
static void a_word_is_kept() {
    board.keep(0x12345678);
    boot_board();
    CHECK(board.kept() == 0x12345678 && (SNVS_LPCR & 1 << 24) != 0);
    SNVS_LPGPR0 = 5;
    CHECK(board.kept() == 0);
    SNVS_LPGPR0 = SNVS_LPGPR1 = 0;
    CHECK(board.kept() == 0);
    WDOG1_WRSR = 2;
    CHECK(board.watchdog_reset());
    WDOG1_WRSR = 0;
}

/// A key is deleted by a pin that is connected to ground during a boot.
static void a_key_is_recovered() {
    const std::uint8_t secret[key_size] = {1, 2, 3};
    CHECK(set_key(app.vehicle, ground, secret) == Refusal::none);
    float_on(50), boot_board();
    CHECK(key(app.vehicle) != nullptr);
    stand_in::digital[robot::wiring.recovery[0]] = LOW;
    boot_board();
    CHECK(key(app.vehicle) == nullptr && !app.vehicle.locked);
    stand_in::digital.clear();
}

/// Fixes that the receiver itself calls bad are none; a good one has its accuracy.
static void bad_fixes_are_none() {
    const auto read = [](int type, int valid, int invalid) {
        Serial8.line.clear();
        put_fix(Serial8, 300000000, 1200000000, type, valid, invalid);
        for (int k = 0; k < 4; ++k) {
            loop();
            if (app.vehicle.raw.fixed) return true;
        }
        return false;
    };
    boot_board(), float_on(100);
    CHECK(read(3, 1, 0) && app.vehicle.raw.accuracy == 2500 && app.vehicle.raw.satellites == 9);
    CHECK(!read(2, 1, 0) && !read(3, 0, 0) && !read(3, 1, 1) && !read(0, 1, 0));
}

/// Receiver and IMU are set up at the rate that they come with and at their own: at boot, and again when they are
/// silent, since they lose their settings with their power.
static void devices_get_their_settings() {
    const auto forget = [] {
        for (HardwareSerialIMXRT* port : {&Serial1, &Serial8})
            port->out.clear(), port->line.clear(), port->ring.clear(), port->rates = {port->rates.back()};
    };
    const ReceiverSettings settings(1000);
    CHECK(robot::wiring.fix_ms == 1000 && settings.size == 11 + 14 + 44 + 28 + 46);
    int sums = 0;  // of every message, by its length
    for (int at = 0; at < settings.size; at += settings.bytes[at + 4] + 8) {
        std::uint8_t sum[2];
        const int size = settings.bytes[at + 4] + 8;
        sum_message(settings.bytes + at, size, sum);
        sums += settings.bytes[at] == 0xb5 && settings.bytes[at + size - 2] == sum[0] &&
                settings.bytes[at + size - 1] == sum[1];
    }
    CHECK(sums == 5);
    const auto twice = [&] {
        const std::size_t size = std::size_t(settings.size);
        return Serial8.out.size() == 2 * size && std::memcmp(&Serial8.out[0], settings.bytes, size) == 0 &&
               std::memcmp(&Serial8.out[size], settings.bytes, size) == 0;
    };
    forget(), boot_board();
    for (int k = 0; k < 40; ++k) loop();
    CHECK(Serial8.rates == (std::vector<std::uint32_t>{38400, 38400, 9600, 38400}) && twice());
    CHECK(Serial1.rates == (std::vector<std::uint32_t>{115200, 115200, 9600, 115200}));
    CHECK(Serial1.out.size() == sizeof(imu_fast) + sizeof(imu_settings));
    forget(), float_on(600);
    CHECK(Serial8.out.empty() && Serial1.out.empty());
    forget();
    for (int k = 0; k < 90; ++k) loop(), CHECK(Serial1.out.empty());
    for (int k = 0; k < 60; ++k) loop();
    CHECK(Serial1.rates == (std::vector<std::uint32_t>{115200, 9600, 115200}) && Serial8.out.empty());
    for (int k = 0; k < 390; ++k) loop();
    CHECK(Serial8.rates == (std::vector<std::uint32_t>{38400, 9600, 38400}) && twice());
}

/// After a long tick no samples are made up for: those of one moment say nothing of the others, and the depth sensor's
/// conversions take their time.
static void after_a_long_tick() {
    float_on(10);
    stand_in::pass(80'000);
    float_on(1);
    CHECK(app.vehicle.raw.channel[first_channel("bend")].count <= 2);
    float_on(1);
    CHECK(app.vehicle.raw.channel[first_channel("bend")].count <= 11);
    CHECK(app.vehicle.raw.channel[first_channel("depth")].count == 1);
}

/// Noise on every line: nothing but good frames gets through, and the next good one does.
static void noise_on_the_lines() {
    ImuParser imu{};
    FixParser fixes{};
    ImuFrame frame;
    Fix fix;
    int false_frames = 0;
    for (int k = 0; k < 300000; ++k) false_frames += imu.take(noise(), frame), false_frames += fixes.take(noise(), fix);
    CHECK(false_frames < 10);  // 3 of 256^2 frames in noise, times one checksum in 256: 0.05 expected
    HardwareSerialIMXRT line;
    line.begin(115'200), line.room = 1 << 20;
    for (int k = 0; k < 200; ++k) {
        std::uint8_t bytes[30];
        for (std::uint8_t& byte : bytes) byte = noise();
        line.come(bytes, noise() % 30);
        put_imu(line, 0x52, {1, 2, 3}), put_imu(line, 0x52, {1, 2, 3});
        put_fix(line, 5, 6), put_fix(line, 5, 6);
    }
    int rates = 0, places = 0;
    stand_in::pass(20'000'000);
    while (line.available() > 0) {
        const std::uint8_t byte = std::uint8_t(line.read());
        rates += imu.take(byte, frame) && frame.value[2] == 3;
        places += fixes.take(byte, fix) && fix.latitude == 5;
    }
    CHECK(rates >= 380 && places >= 380);
}

int main() {
    it_boots_and_reads();
    it_drives_servos();
    parameters_survive_a_reset();
    the_depth_sensor_computes();
    the_black_box_lasts();
    after_a_long_tick();
    rings_hold_a_long_tick();
    a_slow_erasure();
    a_word_is_kept();
    a_key_is_recovered();
    bad_fixes_are_none();
    devices_get_their_settings();
    silent_sensors_and_a_leak();
    a_stuck_bus();
    noise_on_the_lines();
    return failures();
}
