/// The app on the bench board, for tests of its radio.
///
/// `radio_bench` goes in lock-step over standard input and output: each tick takes the length (two bytes) and the bytes
/// that the radio brought, and gives the length and the bytes that it sends, then what the vehicle is doing.
/// `radio_bench PORT` runs by the clock and speaks UDP to 127.0.0.1:PORT, and to the last sender. With a file
/// after the port, the sensors read the eleven numbers in it: acceleration, rate, field, voltage, depth.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "../../boards/pc/radio.hpp"
#include "bench_board.hpp"

using namespace hypertuna::firmware;
using hypertuna::Mode;

static App app;
static BenchBoard board;

struct Report {
    std::uint32_t tick, faults, orders, refused, replayed, frames, bad, skipped, frames_sent, bytes_sent;
    float frequency, amplitude, first;  // frequency and amplitude of the command; value of the first parameter
    std::uint8_t armed, state, max_waiting, waypoints;
};
static_assert(sizeof(Report) == 56);

static bool read_all(void* to, std::size_t count) { return count == 0 || std::fread(to, 1, count, stdin) == count; }

static Report report() {
    const Snapshot& now = snapshot(app.vehicle);
    const Radio& l = app.radio;
    return {now.tick,
            now.faults.flags,
            l.commands,
            l.refused,
            l.replayed,
            l.parser.frames,
            l.parser.bad,
            l.parser.skipped,
            l.out.frames,
            l.out.sent,
            now.command.frequency,
            now.command.amplitude[0],
            value(app.vehicle, 0),
            now.armed(),
            std::uint8_t(now.state),
            std::uint8_t(l.out.max_waiting),
            std::uint8_t(mission(app.vehicle).waypoints)};
}

static int lock_step() {
    std::uint16_t count = 0;
    while (read_all(&count, 2)) {
        board.heard.resize(board.heard.size() + count);
        if (!read_all(board.heard.data() + board.heard.size() - count, count)) return 1;
        tick(app, board);
        count = std::uint16_t(board.said.size());
        const Report state = report();
        std::fwrite(&count, 2, 1, stdout);
        if (count != 0) std::fwrite(board.said.data(), 1, count, stdout);
        std::fwrite(&state, sizeof state, 1, stdout);
        std::fflush(stdout);
        board.said.clear();
    }
    return 0;
}

/// Read the sensors' numbers from a file; keep the former numbers while the file is being written.
static void take_readings(const char* path) {
    std::FILE* file = std::fopen(path, "r");
    float number[11];
    int count = 0;
    while (file != nullptr && count < 11 && std::fscanf(file, "%f", &number[count]) == 1) ++count;
    if (file != nullptr) std::fclose(file);
    if (count < 11) return;
    for (int k = 0; k < 3; ++k)
        board.acceleration[k] = number[k], board.rate[k] = number[3 + k], board.field[k] = number[6 + k];
    board.voltage = number[9], board.depth = number[10];
}

static int by_the_clock(int port, const char* readings) {
    UdpRadio radio;
    if (!radio.open(port)) return 1;
    auto next = std::chrono::steady_clock::now();
    for (;;) {
        std::uint8_t bytes[2048];
        const int got = radio.receive(bytes, int(sizeof bytes));
        board.heard.insert(board.heard.end(), bytes, bytes + got);
        if (readings != nullptr) take_readings(readings);
        tick(app, board);
        if (!board.said.empty()) radio.send(board.said.data(), int(board.said.size()));
        board.said.clear();
        next += std::chrono::milliseconds(10);
        std::this_thread::sleep_until(next);
    }
}

int main(int count, char** words) {
    boot(app, robot::description, board);
    return count > 1 ? by_the_clock(std::atoi(words[1]), count > 2 ? words[2] : nullptr) : lock_step();
}
