/// An SD card with SdFat's interface: after a sector was written it is busy for as long as the test says, and the next
/// write waits unless the caller asks first. Files are contiguous.
#pragma once

#include <string>

#include "Arduino.h"

inline constexpr int BUILTIN_SDCARD = 254, O_RDWR = 2, O_CREAT = 4, O_EXCL = 8;

namespace stand_in {

struct Disk {
    bool missing = false, failing = false;
    std::uint8_t fat = 32;
    std::map<std::string, std::pair<std::uint32_t, std::uint64_t>> files;  // first sector, bytes
    std::map<std::uint32_t, std::vector<std::uint8_t>> sectors;            // sectors that were written
    std::uint32_t free = 100, waits = 0, writes = 0, busy_us = 300, slow_every = 0, slow_us = 0;
    std::uint64_t ready_us = 0;

    bool isBusy() { return pass(1), now_us < ready_us; }
    bool writeSector(std::uint32_t sector, const std::uint8_t* from) {
        if (isBusy()) ++waits, pass(ready_us - now_us);
        if (failing) return false;
        sectors[sector].assign(from, from + 512);
        pass(40), ++writes;
        ready_us = now_us + (slow_every != 0 && writes % slow_every == 0 ? slow_us : busy_us);
        return true;
    }
    bool erase(std::uint32_t first, std::uint32_t last) {
        sectors.erase(sectors.lower_bound(first), sectors.upper_bound(last));
        pass(10'000);
        return true;
    }
    /// Bytes of a file.
    std::vector<std::uint8_t> content(const std::string& name) {
        std::vector<std::uint8_t> all;
        const auto [first, bytes] = files[name];
        for (std::uint32_t k = 0; k < bytes / 512; ++k) {
            const auto found = sectors.find(first + k);
            if (found == sectors.end()) break;
            all.insert(all.end(), found->second.begin(), found->second.end());
        }
        return all;
    }
};
inline Disk disk;

}  // namespace stand_in

struct FsFile {
    std::string name;
    std::uint32_t at = 0;

    explicit operator bool() const { return !name.empty(); }
    bool preAllocate(std::uint64_t bytes) {
        if (name.empty()) return false;
        stand_in::disk.files[name] = {stand_in::disk.free, bytes};
        stand_in::disk.free += std::uint32_t(bytes / 512);
        return true;
    }
    bool contiguousRange(std::uint32_t* first, std::uint32_t* last) {
        const auto [from, bytes] = stand_in::disk.files[name];
        *first = from, *last = from + std::uint32_t(bytes / 512) - 1;
        return true;
    }
    std::uint64_t size() { return stand_in::disk.files[name].second; }
    bool seekSet(std::uint32_t to) { return at = to, true; }
    int read(std::uint8_t* to, std::size_t count) {
        const auto found = stand_in::disk.sectors.find(stand_in::disk.files[name].first + at / 512);
        if (found == stand_in::disk.sectors.end()) return std::memset(to, 0, count), int(count);
        return std::memcpy(to, found->second.data(), count), int(count);
    }
    bool truncate(std::uint64_t bytes) { return stand_in::disk.files[name].second = bytes, true; }
    bool close() { return true; }
};
struct SdFs {
    std::uint8_t fatType() { return stand_in::disk.missing ? 0 : stand_in::disk.fat; }
    bool exists(const char* name) { return stand_in::disk.files.count(name) != 0; }
    FsFile open(const char* name, int flags) {
        if ((flags & O_CREAT) != 0) stand_in::disk.files[name];
        return exists(name) ? FsFile{name} : FsFile{};
    }
    stand_in::Disk* card() { return &stand_in::disk; }
};
struct SDClass {
    SdFs sdfs;
    bool begin(int) { return !stand_in::disk.missing; }
};
inline SDClass SD;
