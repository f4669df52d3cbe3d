/// Board pc: the firmware as a program, in lock-step with a twin over standard input and output.
#include <unistd.h>

#include "../lockstep.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

struct Pipes {
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
    int log(const std::uint8_t*, int count) { return count; }
    // What a tick takes here says nothing of the robot.
    std::uint32_t clock() { return 0; }
    std::uint32_t per_tick() { return 1; }
    std::uint32_t stack() { return 0; }
    int receive(std::uint8_t*, int) { return 0; }
    int send(const std::uint8_t*, int count) { return count; }
};

static App app;
static Plan plan;
static Pipes pipes;
static Lockstep<Pipes> board{pipes, {}, {}, {}};

int main() { run(app, plan, board, robot::description); }
