/// Black box on an SD card: a preallocated file, into which whole sectors are written while the card is not busy.
///
/// A card may be busy for a quarter of a second at any write, and a file system also writes its directory: neither may
/// happen in a tick. The file is contiguous, erased, and has its full length from the beginning, so that nothing is
/// left to be written when the power goes. The next boot cuts off its unused end.
#pragma once

#include <SD.h>

#include <cstdint>

namespace hypertuna::firmware {

inline constexpr std::uint32_t box_bytes = 256u << 20, sector_bytes = 512;  // 3.4 h of a robot with two joints

struct Card {
    std::uint32_t next = 0, end = 0;  // next sector and end of the file; equal without a card
    int filled = 0;
    alignas(4) std::uint8_t sector[sector_bytes];

    void begin() {
        next = end = 0, filled = 0;
        SD.begin(BUILTIN_SDCARD);
        // On exFAT the directory records how much of a file is written: the rest is lost with the power.
        if (SD.sdfs.fatType() != 16 && SD.sdfs.fatType() != 32) return;
        char name[] = "box000.bin";
        int number = 0;
        for (; number < 1000; ++number)
            if (!SD.sdfs.exists(named(name, number))) break;
        if (0 < number) cut_end(named(name, number - 1));
        FsFile file = SD.sdfs.open(named(name, number), O_RDWR | O_CREAT | O_EXCL);
        std::uint32_t first = 0, last = 0;
        const bool laid_out = file.preAllocate(box_bytes) && file.contiguousRange(&first, &last) && file.close();
        if (laid_out && erase(first, last + 1)) next = first, end = last + 1;
    }

    /// Take the bytes that fit, and return their number; a full sector is written when the card is ready. A card that
    /// failed takes no more bytes.
    int write(const std::uint8_t* from, int count) {
        if (next == end) return 0;
        int taken = 0;
        while (taken < count && filled < int(sector_bytes)) sector[filled++] = from[taken++];
        if (filled == int(sector_bytes) && !SD.sdfs.card()->isBusy()) {
            if (SD.sdfs.card()->writeSector(next, sector))
                ++next, filled = 0;
            else
                end = next;
        }
        return taken;
    }

  private:
    /// Erase sectors in pieces, because the library waits up to a second for each.
    static bool erase(std::uint32_t from, std::uint32_t to) {
        constexpr std::uint32_t piece = 1 << 15;
        for (; from < to; from += piece)
            if (!SD.sdfs.card()->erase(from, from + piece < to ? from + piece - 1 : to - 1)) return false;
        return true;
    }
    static const char* named(char* name, int number) {
        name[3] = char('0' + number / 100), name[4] = char('0' + number / 10 % 10), name[5] = char('0' + number % 10);
        return name;
    }
    /// Whether a sector is still erased: a sector of records has marks.
    bool is_unused(FsFile& file, std::uint32_t number) {
        if (!file.seekSet(number * sector_bytes) || file.read(sector, sector_bytes) != int(sector_bytes)) return false;
        for (std::uint32_t k = 0; k < sector_bytes; ++k)
            if (sector[k] != sector[0]) return false;
        return sector[0] == 0 || sector[0] == 0xff;
    }
    /// Cut the unused end off the last boot's file.
    void cut_end(const char* name) {
        FsFile file = SD.sdfs.open(name, O_RDWR);
        if (!file || file.size() != box_bytes) return;
        std::uint32_t low = 0, high = box_bytes / sector_bytes;
        while (low < high) {
            const std::uint32_t middle = (low + high) / 2;
            if (is_unused(file, middle))
                high = middle;
            else
                low = middle + 1;
        }
        file.truncate(low * sector_bytes), file.close();
    }
};

}  // namespace hypertuna::firmware
