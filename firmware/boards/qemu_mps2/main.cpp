/// Board qemu_mps2: the firmware on an emulated Cortex-M7 (QEMU, machine mps2-an500), in lock-step with a twin through
/// two FIFOs, its radio on the first UART.
///
/// With -icount shift=6 an instruction takes 64 ns of the emulated time, and the SysTick counts every 40 ns: the clock
/// counts instructions, so that runs repeat exactly.
#include "../lockstep.hpp"
#include "semihosting.hpp"
#include HYPERTUNA_ROBOT

using namespace hypertuna::firmware;

extern "C" std::uint32_t stack_top, stack_bottom;

static volatile std::uint32_t& at(std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); }

/// CMSDK UART (ARM DDI 0479): data, state (1 transmitter full, 2 receiver full), control, interrupts, divider.
struct Uart {
    static constexpr std::uint32_t base = 0x40004000;

    void begin() {
        at(base + 16) = 16;
        at(base + 8) = 3;
    }
    int receive(std::uint8_t* to, int limit) {
        int count = 0;
        while (count < limit && (at(base + 4) & 2) != 0) to[count++] = std::uint8_t(at(base));
        return count;
    }
    int send(const std::uint8_t* from, int count) {
        int sent = 0;
        while (sent < count && (at(base + 4) & 1) == 0) at(base) = from[sent++];
        return sent;
    }
};

struct Fifos {
    int in, out, box;
    Uart uart;

    bool begin() {
        at(0xe000e014) = 0x00ffffff;  // SysTick: 24 bits down, at the processor's clock
        at(0xe000e018) = 0;
        at(0xe000e010) = 5;
        uart.begin();
        in = semihosting::open("to_board", 8, semihosting::Access::read);
        out = semihosting::open("from_board", 10, semihosting::Access::write);
        box = semihosting::open("black_box", 9, semihosting::Access::write);
        return in >= 0 && out >= 0;
    }
    bool read(void* to, std::size_t count) {
        auto* next = static_cast<std::uint8_t*>(to);
        while (count > 0) {
            const std::size_t missing = std::size_t(semihosting::read(in, next, count));
            if (missing >= count) return false;
            next += count - missing, count = missing;
        }
        return true;
    }
    void write(const void* from, std::size_t count) {
        const auto* next = static_cast<const std::uint8_t*>(from);
        while (count > 0) {
            const std::size_t missing = std::size_t(semihosting::write(out, next, count));
            if (missing >= count) semihosting::exit(71);
            next += count - missing, count = missing;
        }
    }
    int log(const std::uint8_t* from, int count) {
        return box < 0 ? count : count - semihosting::write(box, from, std::size_t(count));
    }
    std::uint32_t clock() {  // SysTick wraps after 0.67 s, and a tick takes 0.01 s
        const std::uint32_t now = at(0xe000e018);
        counted += (before - now) & 0xffffff;
        before = now;
        return counted;
    }
    std::uint32_t per_tick() { return 250'000; }
    std::uint32_t stack() {
        const std::uint32_t* word = &stack_bottom;
        while (word < &stack_top && *word == 0xa5a5a5a5) ++word;
        return std::uint32_t(&stack_top - word) * 4;
    }
    int receive(std::uint8_t* to, int count) { return uart.receive(to, count); }
    int send(const std::uint8_t* from, int count) { return uart.send(from, count); }

  private:
    std::uint32_t counted, before;
};

static App app;
static MissionBuffer buffer;
static Fifos fifos;
static FlashMemory memory;
static Lockstep<Fifos> board{fifos, memory, {}, {}};

int main() {
    if (!fifos.begin()) return 72;
    run(app, buffer, board, robot::description);
    return 0;
}
