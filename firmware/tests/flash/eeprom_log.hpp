/// The emulated EEPROM of a Teensy 4.1, as its core has it, described in our own words.
///
/// Every four bytes of the EEPROM belong to another of 63 flash sectors in turn. A sector is a log of pairs (offset,
/// value), and a byte's last pair counts. Only when a log of 2,048 pairs is full is it collected: the values are kept
/// in memory, the sector is erased, and they are programmed anew pair by pair. A loss of power meanwhile takes all
/// bytes of that sector: some of every block of EEPROM that is longer than 252 bytes.
#pragma once

#include "flash.hpp"

namespace hypertuna::firmware {

struct EepromLog {
    static constexpr int sectors = 63, pairs = flash_sector / 2, per_sector = 68;

    Flash<sectors> flash;
    int used[sectors];  // pairs of each log

    void boot() {
        flash.boot();
        for (int sector = 0; sector < sectors; ++sector) {
            used[sector] = 0;
            while (used[sector] < pairs && pair(sector, used[sector]) != 0xffff) ++used[sector];
        }
    }
    std::uint8_t read(int at) const {
        const int sector = sector_of(at), offset = offset_of(at);
        for (int k = used[sector] - 1; k >= 0; --k)
            if (int(pair(sector, k) & 0xff) == offset) return std::uint8_t(pair(sector, k) >> 8);
        return 0xff;
    }
    void write(int at, std::uint8_t value) {
        const int sector = sector_of(at);
        if (read(at) == value) return;
        if (used[sector] < pairs) return append(sector, offset_of(at), value);
        std::uint8_t kept[256];
        std::memset(kept, 0xff, sizeof(kept));
        for (int k = 0; k < pairs; ++k) kept[pair(sector, k) & 0xff] = std::uint8_t(pair(sector, k) >> 8);
        kept[offset_of(at)] = value;
        flash.erase(sector), used[sector] = 0;
        for (int k = 0; k < 256; ++k)
            if (kept[k] != 0xff) append(sector, k, kept[k]);
    }

    static int sector_of(int at) { return at / 4 % sectors; }
    static int offset_of(int at) { return at % 4 + at / (4 * sectors) * 4; }

  private:
    std::uint16_t pair(int sector, int k) const {
        const std::uint8_t* at = flash.bytes + sector * flash_sector + 2 * k;
        return std::uint16_t(at[0] | at[1] << 8);
    }
    void append(int sector, int offset, std::uint8_t value) {
        const std::uint8_t both[2] = {std::uint8_t(offset), value};
        flash.program(sector * flash_sector + 2 * used[sector]++, both, 2);
    }
};

}  // namespace hypertuna::firmware
