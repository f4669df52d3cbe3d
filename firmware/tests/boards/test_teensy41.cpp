/// Board teensy41 against a stand-in for the Arduino API: sensors in, servos out, parsers that survive noise.
#include "../../../core/tests/check.hpp"
#include "../../boards/teensy41/main.cpp"

using namespace hypertuna;

static constexpr Station ground{255, 190};

static std::uint32_t noise_state = 1;
static std::uint8_t noise() { return std::uint8_t((noise_state = noise_state * 1664525u + 1013904223u) >> 24); }

static void put_imu(HardwareSerial& line, std::uint8_t kind, const int (&value)[3]) {
    std::uint8_t bytes[11] = {0x55, kind}, sum = 0;
    for (int k = 0; k < 3; ++k)
        bytes[2 + 2 * k] = std::uint8_t(value[k]), bytes[3 + 2 * k] = std::uint8_t(value[k] >> 8);
    for (int k = 0; k < 10; ++k) sum = std::uint8_t(sum + bytes[k]);
    bytes[10] = sum;
    line.in.insert(line.in.end(), bytes, bytes + 11);
}

static void put_fix(HardwareSerial& line, std::int32_t latitude, std::int32_t longitude) {
    std::uint8_t bytes[100] = {0xb5, 0x62, 1, 7, 92, 0}, a = 0, b = 0;
    bytes[26] = 3, bytes[27] = 1;
    std::memcpy(bytes + 30, &longitude, 4), std::memcpy(bytes + 34, &latitude, 4);
    for (int k = 2; k < 98; ++k) a = std::uint8_t(a + bytes[k]), b = std::uint8_t(b + a);
    bytes[98] = a, bytes[99] = b;
    line.in.insert(line.in.end(), bytes, bytes + 100);
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

static void it_boots_and_reads() {
    setup();
    CHECK(Serial2.rate == 9600 && SD.name == "box002.bin");
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
    CHECK(!now.faults.has(firmware::Fault::overrun));
    CHECK(!Serial2.out.empty());  // telemetry
}

static void it_drives_servos() {
    for (Servo& one : board.servo) CHECK(!one.attached());
    CHECK(give(app.vehicle, Order::arm, ground) == Refusal::none);
    Command<float> beat = rest();
    beat.frequency = 2, beat.amplitude[0] = beat.amplitude[1] = 0.25f;
    CHECK(set_gait(app.vehicle, ground, beat) == Refusal::none);
    int least = 9999, most = 0;
    for (int k = 0; k < 300; ++k) {
        on_ground_contact(app.vehicle, ground), float_on(1);
        CHECK(board.servo[0].pin == robot::wiring.servo[0]);
        least = std::min(least, board.servo[0].pulse), most = std::max(most, board.servo[0].pulse);
    }
    CHECK(800 <= least && least < 1490 && 1510 < most && most <= 2200);
    give(app.vehicle, Order::disarm, ground), float_on(300);
    for (Servo& one : board.servo) CHECK(!one.attached());
}

static void parameters_survive_a_reset() {
    int k = 0;
    while (std::strcmp(parameter(app.vehicle, k).name, "learning") != 0) ++k;
    CHECK(set_parameter(app.vehicle, ground, k, 0.25f) == Refusal::none);
    float_on(200);
    setup();
    CHECK(value(app.vehicle, k) == 0.25f && !app.vehicle.defaults);
    CHECK(SD.content.size() > 100 * 200);  // and the black box has its records
}

static void silent_sensors_and_a_leak() {
    Wire.silent = true;
    Serial1.in.clear();
    stand_in::digital[robot::wiring.leak[0]] = LOW;
    for (int k = 0; k < 150; ++k) loop();
    const Snapshot& now = snapshot(app.vehicle);
    CHECK(now.faults.has(firmware::Fault::imu) && now.faults.has(firmware::Fault::leak) && !now.estimate.depths);
    Wire.silent = false, stand_in::digital.clear();
}

/// A card keeps what was written to it up to the last flush: all but the last two seconds. Without a card the black box
/// says so.
static void the_black_box_lasts() {
    setup();
    SD.content.clear(), SD.lasting = 0;
    float_on(1000);
    CHECK(SD.content.size() > 200'000 && SD.content.size() - SD.lasting < 2 * 22'000);
    SD.missing = true;
    setup();
    float_on(100);
    CHECK(snapshot(app.vehicle).faults.has(firmware::Fault::black_box));
    SD.missing = false;
    setup();
}

/// After a long tick no samples are made up for: those of one moment say nothing of the others, and the depth sensor's
/// conversions take their time.
static void after_a_long_tick() {
    float_on(10);
    stand_in::now_us += 80'000;
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
    HardwareSerial line;
    for (int k = 0; k < 200; ++k) {
        for (int n = noise() % 30; n > 0; --n) line.in.push_back(noise());
        put_imu(line, 0x52, {1, 2, 3}), put_imu(line, 0x52, {1, 2, 3});
        put_fix(line, 5, 6), put_fix(line, 5, 6);
    }
    int rates = 0, places = 0;
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
    the_black_box_lasts();
    after_a_long_tick();
    silent_sensors_and_a_leak();
    noise_on_the_lines();
    return failures();
}
