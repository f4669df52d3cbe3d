/// Board pc: the firmware as a program, in lock-step with a twin over standard input and output, its radio on UDP
/// to a ground station at 127.0.0.1:PORT, its black box in a file:
///
///     hypertuna-pc [--udp PORT] [--box FILE]
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "../lockstep.hpp"
#include "radio.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

struct Pipes {
    UdpRadio radio;
    int box = -1;

    bool read(void* to, std::size_t count) {
        auto* at = static_cast<std::uint8_t*>(to);
        while (count > 0) {
            const ssize_t got = ::read(0, at, count);
            if (got <= 0) return false;
            at += got, count -= std::size_t(got);
        }
        return true;
    }
    void write(const void* from, std::size_t count) {
        const auto* at = static_cast<const std::uint8_t*>(from);
        while (count > 0) {
            const ssize_t put = ::write(1, at, count);
            if (put <= 0) _exit(1);
            at += put, count -= std::size_t(put);
        }
    }
    int log(const std::uint8_t* from, int count) {
        if (box < 0) return count;
        const ssize_t put = ::write(box, from, std::size_t(count));
        return put < 0 ? 0 : int(put);
    }
    // Times on this machine say nothing about the robot.
    std::uint32_t clock() { return 0; }
    std::uint32_t per_tick() { return 250'000; }  // the same as on qemu_mps2
    std::uint32_t stack() { return 0; }
    int receive(std::uint8_t* to, int count) { return radio.receive(to, count); }
    int send(const std::uint8_t* from, int count) { return radio.send(from, count); }
};

static App app;
static MissionBuffer buffer;
static Pipes pipes;
static FlashMemory memory;
static Lockstep<Pipes> board{pipes, memory, {}, {}};

int main(int count, char** words) {
    for (int k = 1; k < count; k += 2) {
        const char* value = k + 1 < count ? words[k + 1] : "";
        if (std::strcmp(words[k], "--udp") == 0 && pipes.radio.open(std::atoi(value))) continue;
        if (std::strcmp(words[k], "--box") == 0 && (pipes.box = ::open(value, O_WRONLY | O_CREAT | O_TRUNC, 0666)) >= 0)
            continue;
        std::fprintf(stderr, "hypertuna-pc: cannot take %s %s\nusage: hypertuna-pc [--udp PORT] [--box FILE]\n",
                     words[k], value);
        return 2;
    }
    run(app, buffer, board, robot::description);
}
