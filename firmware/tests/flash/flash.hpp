/// A model of real flash memory (NOR, W25Q64): erased by sectors to ones, programmed by pages to zeros, and cut off
/// anywhere.
///
/// What a cut leaves: of an erasure, any bytes of the sector changed to anything; of a programming, any of its bits
/// done, at times with others of its page cleared. Half-done bits are weak: they read one way or the other, anew at
/// each boot, until an erasure or a programming to zero is completed over them.
#pragma once

#include <cstdint>
#include <cstring>

#include "app/board.hpp"

namespace hypertuna::firmware {

/// Random numbers for a test.
struct Dice {
    std::uint64_t state = 1;

    std::uint32_t roll() {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return std::uint32_t(state >> 33);
    }
    int below(int end) { return int(roll() % std::uint32_t(end)); }
    bool happens(double probability) { return roll() < probability * 2147483648.0; }
    std::uint8_t byte() { return std::uint8_t(roll() >> 7); }
};

template <int sectors>
struct Flash {
    std::uint8_t bytes[sectors * flash_sector], weak[sectors * flash_sector];
    int operations, erasures;  // since the flash was new
    int power;                 // operations until the power fails during one; negative: never
    bool off;
    int worn;  // address of a worn cell that keeps its value; negative: none
    Dice dice;

    void begin() {
        std::memset(bytes, 0xff, sizeof(bytes)), std::memset(weak, 0, sizeof(weak));
        operations = erasures = 0, power = worn = -1, off = false;
    }
    /// Restore the power: weak bits fall one way or the other.
    void boot() {
        off = false, power = -1;
        static const std::uint8_t none[flash_page] = {};
        for (int k = 0; k < int(sizeof(bytes)); ++k)
            if (k % flash_page == 0 && std::memcmp(weak + k, none, flash_page) == 0)
                k += flash_page - 1;
            else if (weak[k] != 0)
                bytes[k] = std::uint8_t((bytes[k] & ~weak[k]) | (dice.byte() & weak[k]));
    }
    void load(int at, std::uint8_t* to, int count) const { std::memcpy(to, bytes + at, std::size_t(count)); }

    void erase(int sector) {
        const bool cut = begins_cut();
        if (off && !cut) return;
        ++erasures;
        const double part = cut ? some_part() : 1;
        for (int k = sector * flash_sector; k < (sector + 1) * flash_sector; ++k) {
            if (k == worn || (cut && !dice.happens(part))) continue;
            bytes[k] = cut ? dice.byte() : std::uint8_t(0xff), weak[k] = cut ? dice.byte() : std::uint8_t(0);
        }
    }
    void program(int at, const std::uint8_t* from, int count) {
        const bool cut = begins_cut();
        if (off && !cut) return;
        outside += at / flash_page != (at + count - 1) / flash_page;  // the write would wrap to the begin of its page
        const double part = cut ? some_part() : 1, weakness = dice.happens(0.5) ? 0.5 : 0.03;
        for (int k = 0; k < count; ++k) {
            if (at + k == worn) continue;
            const std::uint8_t done = std::uint8_t(~from[k] & (cut ? bits(part) : 0xff));
            const std::uint8_t fresh = std::uint8_t(done & (bytes[at + k] | weak[at + k]));  // not zero for good before
            bytes[at + k] = std::uint8_t(bytes[at + k] & ~done), weak[at + k] = std::uint8_t(weak[at + k] & ~done);
            if (cut) weak[at + k] = std::uint8_t(weak[at + k] | (fresh & bits(weakness)));
        }
        const int page = at / flash_page * flash_page;
        const bool strays = cut && dice.happens(0.3);
        for (int k = page; strays && k < page + flash_page; ++k)
            if (dice.happens(part)) {
                const std::uint8_t cleared = std::uint8_t(bytes[k] & dice.byte());
                bytes[k] = std::uint8_t(bytes[k] & ~cleared), weak[k] = std::uint8_t(weak[k] | (cleared & dice.byte()));
            }
    }

    int outside = 0;  // programmings over the end of a page

  private:
    /// Whether the power goes during the operation that begins.
    bool begins_cut() {
        if (off) return false;
        ++operations;
        if (power == 0) return off = true;
        if (power > 0) --power;
        return false;
    }
    /// Completed part of an interrupted operation: often next to nothing, or nearly all.
    double some_part() {
        const double part = double(dice.below(1001)) / 1000;
        const int kind = dice.below(4);
        return kind == 0 ? 0.002 * part : kind == 1 ? 1 - 0.002 * part : part;
    }
    std::uint8_t bits(double part) {
        std::uint8_t set = 0;
        for (int k = 0; k < 8; ++k) set = std::uint8_t(set | int(dice.happens(part)) << k);
        return set;
    }
};

}  // namespace hypertuna::firmware
