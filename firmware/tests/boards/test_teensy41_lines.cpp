/// Tests of the lines of board teensy41: good and bad bytes on serial ports and I2C, and the time that they cost.
#include "teensy_test.hpp"

/// The example of the application note on the checksum, and second-order compensation against integers of Python.
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

/// After a long tick missed samples are not made up for: samples of one moment tell nothing about the others, and
/// conversions of the depth sensor take their time.
static void after_a_long_tick() {
    float_on(10);
    stand_in::pass(80'000);
    float_on(1);
    CHECK(app.vehicle.raw.channel[first_channel("bend")].count <= 2);
    float_on(1);
    CHECK(app.vehicle.raw.channel[first_channel("bend")].count <= 11);
    CHECK(app.vehicle.raw.channel[first_channel("depth")].count == 1);
}

/// Bytes that come during a long tick wait in the rings: at 60 ms there are more than the core's 64.
static void rings_hold_a_long_tick() {
    boot_board(), float_on(100);  // until the devices are set up
    const std::uint32_t lost = Serial1.lost + Serial8.lost;
    for (int k = 0; k < 12; ++k) put_imu(Serial1, 0x52, {1, 2, 3});
    put_fix(Serial8, 300000000, 1200000000);
    CHECK(Serial1.line.size() > 64 && Serial8.line.size() > 64);
    stand_in::pass(60'000);
    float_on(3);
    CHECK(Serial1.lost + Serial8.lost == lost && Serial1.ring.empty());
}

/// Fixes that the receiver itself marks as bad are not used; a good one has the receiver's accuracy.
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

/// Receiver and IMU are set up both at their factory rate and at the board's rate: at boot, and again when they are
/// silent, since they lose their settings with their power.
static void devices_get_their_settings() {
    const auto forget = [] {
        for (HardwareSerialIMXRT* port : {&Serial1, &Serial8})
            port->out.clear(), port->line.clear(), port->ring.clear(), port->rates = {port->rates.back()};
    };
    const ReceiverSettings settings(1000);
    CHECK(robot::wiring.fix_ms == 1000 && settings.size == 11 + 14 + 44 + 28 + 46);
    int sums = 0;  // checksums of every message, by its length
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

/// A bus that is held low costs one late tick, then only a short check each second; clock pulses free it.
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
    bus.blind = true;  // then each check of a stuck bus costs a late tick, once a second
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

/// A failing sensor is left alone for a second, because each try may cost a late tick.
static void a_sensor_that_fails_again() {
    stand_in::Bus& bus = stand_in::bus;
    for (bool* failure : {&bus.hangs, &bus.silent}) {
        boot_board(), float_on(50);
        CHECK(app.vehicle.raw.channel[first_channel("depth")].count == 1);
        *failure = true;
        const int before = bus.transfers;
        int late = 0;
        for (int k = 0; k < 500; ++k) late += longest_tick(1) > 11'000;
        CHECK(3 <= bus.transfers - before && bus.transfers - before <= 6);
        CHECK(late == (failure == &bus.hangs ? bus.transfers - before : 0));
        *failure = false;
    }
}

/// Noise on every line: only good frames get through, and the next good one does.
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
    Serial1.device = imu_baud, Serial8.device = receiver_baud;
    the_depth_sensor_computes();
    boot_board();
    after_a_long_tick();
    rings_hold_a_long_tick();
    bad_fixes_are_none();
    devices_get_their_settings();
    silent_sensors_and_a_leak();
    a_stuck_bus();
    a_sensor_that_fails_again();
    noise_on_the_lines();
    return failures();
}
