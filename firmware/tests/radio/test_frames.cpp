/// Tests of frames: found in any stream of bytes, old ones refused; angles and numbers of the messages.
#include <algorithm>

#include "radio_test.hpp"

/// Check value of CRC-16/MCRF4XX (reveng.sourceforge.io/crc-catalogue), and of SHA-256 (FIPS 180-4, "abc").
static void test_checksums() {
    std::uint16_t crc = 0xFFFF;
    for (char c : {'1', '2', '3', '4', '5', '6', '7', '8', '9'}) crc = crc_step(crc, std::uint8_t(c));
    CHECK(crc == 0x6F91);
    Sha256 hash;
    add(hash, reinterpret_cast<const std::uint8_t*>("abc"), 3);
    std::uint8_t digest[32];
    finish(hash, digest, 32);
    CHECK(digest[0] == 0xba && digest[1] == 0x78 && digest[2] == 0x16 && digest[3] == 0xbf && digest[31] == 0xad);
}

/// A good frame is found after any bytes, and inside a bad frame.
static void test_parser_finds_what_is_good() {
    Bench bench;
    const Bytes good = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        Bytes stream(random_bits(seed, 0, 0) % 400);
        for (std::size_t k = 0; k < stream.size(); ++k) stream[k] = std::uint8_t(random_bits(seed, 1, k));
        if (seed % 2) stream.insert(stream.end(), good.begin(), good.begin() + long(seed / 2 % (good.size() - 1)));
        stream.insert(stream.end(), good.begin(), good.end());
        Parser parser{};
        Frame frame{};
        int found = 0;
        for (std::size_t at = 0; at < stream.size();) {
            at += std::size_t(feed(parser, &stream[at], int(stream.size() - at)));
            while (next(parser, frame)) ++found;
        }
        // A frame that waits for missing bytes is dropped when the next good frame is complete.
        for (std::uint8_t byte : good) feed(parser, &byte, 1);
        while (next(parser, frame)) ++found;
        CHECK(found == 2);
    }
}

/// Any single flipped bit is detected; two thirds of the frame's bytes may be anything.
static void test_no_flipped_bit_passes() {
    Bench bench;
    const Bytes good = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bad = good;
        bad[bit / 8] = std::uint8_t(bad[bit / 8] ^ 1 << bit % 8);
        Parser parser{};
        Frame frame{};
        feed(parser, bad.data(), int(bad.size()));
        CHECK(!next(parser, frame));
    }
}

/// A repeated frame and an overtaken one are old, and so is a whole window. After silence the sequence of a sender
/// starts again.
static void test_replay_is_refused() {
    Bench bench;
    const Bytes arm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    const Bytes disarm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    bench.hear(disarm), bench.run(40);
    bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed());
    bench.hear(disarm), bench.run(40);
    CHECK(bench.app.radio.replayed == 1);  // only the arming: disarming is always accepted
    CHECK(texts_sent(bench, Refusal::replayed) == 1);
    bench.run(int(silence) + 1);
    bench.hear(arm), bench.run(40);
    CHECK(snapshot(bench.vehicle()).armed());
}

/// Angles for the compass rose, against the C library.
static void test_angles() {
    double worst = 0;
    for (int k = 0; k < 100000; ++k) {
        const double a = 2 * pi * k / 100000 - pi;
        const float y = float(std::sin(a)), x = float(std::cos(a));
        worst = std::max(worst, std::fabs(double(angle_of(y, x)) - std::atan2(double(y), double(x))));
    }
    CHECK(worst < 2e-5);
    CHECK(whole<std::int16_t>(1e9f, 1.0f) == 32767 && whole<std::int16_t>(-1e9f, 1.0f) == -32768);
    CHECK(whole<std::uint16_t>(-3.0f, 1.0f) == 0 && whole<std::int16_t>(-2.5f, 1.0f) == -3);
    CHECK(whole<std::int32_t>(4e9f, 1.0f) == INT32_MAX);
}

int main() {
    test_checksums();
    test_parser_finds_what_is_good();
    test_no_flipped_bit_passes();
    test_replay_is_refused();
    test_angles();
    return failures();
}
