/// Tests of board teensy41 on a stand-in for the Arduino API: sensors in, servos out, stored data.
#include "teensy_test.hpp"

static void it_boots_and_reads() {
    Serial1.device = imu_baud, Serial8.device = receiver_baud;
    boot_board();
    CHECK(Serial2.rates.back() == 9600 && stand_in::disk.files.count("box000.bin") == 1);
    float_on(200);
    const Snapshot& now = snapshot(app.vehicle);
    CHECK(now.tick == 200);
    CHECK_NEAR(now.readings.robot.pressure[2], 60e3, 1300);  // 12 bits: 336 Pa
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

/// Pulses come from timers: 50 per second, each within a microsecond of the commanded width, none for 0.
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

/// The card holds all but the last sectors, whenever the power fails. A slow card delays no tick; records that it
/// cannot take in time are lost, and this is reported. At the next boot the file is cut to the written part.
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

/// During an erasure of the longest duration in the data sheet the watchdog does not reset, and the clock keeps time.
static void a_slow_erasure() {
    boot_board(), float_on(100);
    stand_in::erase_us = 400'000;
    int k = 0;
    while (std::strcmp(parameter(app.vehicle, k).name, "learning") != 0) ++k;
    CHECK(set_parameter(app.vehicle, ground, k, 0.5f) == Refusal::none);
    const std::uint32_t before = board.clock(), us = micros();
    float_on(30);
    CHECK(settled(app.vehicle.store) && stand_in::watchdog.bites == 0);
    CHECK(!snapshot(app.vehicle).faults.has(firmware::Fault::overrun));
    CHECK(board.clock() - before > 600 * (std::uint32_t(micros()) - us + 390'000));
    for (std::uint32_t wait :
         {400'000u, 0u}) {  // the erasure does not count together with the ticks before or after it
        board.feed();
        stand_in::pass(wait);
        board.erase(witness_sector);
        stand_in::pass(400'000 - wait);
        board.feed();
        CHECK(stand_in::watchdog.bites == 0);
    }
    stand_in::erase_us = 45'000;
}

/// A word survives a reset; a register with any other content holds no word.
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
    stand_in::erase_us = 400'000;  // three erasures: the watchdog is fed between them
    boot_board();
    CHECK(stand_in::watchdog.bites == 0);
    stand_in::erase_us = 45'000;
    CHECK(key(app.vehicle) == nullptr && !app.vehicle.locked);
    stand_in::digital.clear();
}

int main() {
    it_boots_and_reads();
    it_drives_servos();
    parameters_survive_a_reset();
    the_black_box_lasts();
    a_slow_erasure();
    a_word_is_kept();
    a_key_is_recovered();
    return failures();
}
