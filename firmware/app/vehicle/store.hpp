/// Store: data in two sectors of flash memory, of which the one with the valid record is never erased.
///
/// A sector is a log of records: head (layout, turn, checksum), data, and three flags. The valid record with the
/// latest turn counts. The first write after a boot erases the other sector, later ones append to it while it
/// has room: cells that a loss of power left half programmed or half erased are never written on. The record is read
/// back before its flags make it valid. Each call does one operation of the memory.
///
/// A half programmed flag may be read as set or not, and differently at each boot. So a boot makes what it reads
/// permanent before using it: a record that is `written` and not `void` becomes `certain`, any other record becomes
/// void.
#pragma once

#include <cstring>

#include "app/board.hpp"

namespace hypertuna::firmware {

/// CRC-32 (IEEE 802.3, reflected) of some bytes, continued from `crc`, half a byte at a time.
inline std::uint32_t crc32(const std::uint8_t* from, int count, std::uint32_t crc = 0) {
    static constexpr std::uint32_t rest[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                               0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                               0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    crc = ~crc;
    for (int k = 0; k < count; ++k) {
        crc = rest[(crc ^ from[k]) & 15] ^ crc >> 4;
        crc = rest[(crc ^ from[k] >> 4) & 15] ^ crc >> 4;
    }
    return ~crc;
}

inline constexpr int piece = 64;  // bytes programmed at once; a page has four
static_assert(flash_page % piece == 0);

/// Head of a record, in a piece of its own.
struct Head {
    std::uint32_t layout, turn, checksum;

    bool operator==(const Head&) const = default;
};
inline constexpr Head blank_head{~0u, ~0u, ~0u};

/// Flags of a record, in a page each. A flag is set by zeros: when half programmed it can still be completed, and only
/// an erasure clears it.
enum class Flag { written, is_void, certain, count };

/// Place of a store, and progress of the write. The data itself lies elsewhere, in `size` bytes.
struct Store {
    int base, size;              // first of the two sectors; bytes of data
    std::uint32_t layout, turn;  // layout of the data; number of the valid record
    int kept;                    // sector of the valid record, 0 or 1; -1 if there is none
    int sector, slot;            // place of the record written last or now; slot -1: a sector must be erased first
    int step;                    // step of the write, -1 if there is none
    bool again, failed;          // the data changed during the write; the last record was read back wrong
    Head head;                   // head of the record being written
};

/// Number of pages of head and data. Data and flags share none: a loss of power spoils only the page that is written.
inline int data_pages(const Store& store) { return (piece + store.size + flash_page - 1) / flash_page; }
inline int flag_at(const Store& store, Flag flag) { return (data_pages(store) + int(flag)) * flash_page; }
inline int record_size(const Store& store) { return flag_at(store, Flag::count); }
inline Store store_at(int base, int size, std::uint32_t layout) {
    return {base, size, layout, 0, -1, 0, -1, -1, false, false, {}};
}
inline int records(const Store& store) { return flash_sector / record_size(store); }  // records per sector
inline int address(const Store& store, int sector, int slot) {
    return (store.base + sector) * flash_sector + slot * record_size(store);
}

/// Checksum of layout and turn, which the checksum of the data continues.
inline std::uint32_t checksum(const Head& head) { return crc32(reinterpret_cast<const std::uint8_t*>(&head), 8); }

template <class Words, Board B>
Words load_words(B& board, int at) {
    Words words;
    board.load(at, reinterpret_cast<std::uint8_t*>(&words), int(sizeof(words)));
    return words;
}
template <class Words, Board B>
void program_words(B& board, int at, const Words& words) {
    board.program(at, reinterpret_cast<const std::uint8_t*>(&words), int(sizeof(words)));
}

/// Whether layout and checksum of the record at an address are right.
template <Board B>
bool is_whole(B& board, const Store& store, const Head& head, int at) {
    if (head.layout != store.layout) return false;
    std::uint8_t part[piece];
    std::uint32_t crc = checksum(head);
    for (int from = 0; from < store.size; from += piece) {
        const int count = store.size - from < piece ? store.size - from : piece;
        board.load(at + piece + from, part, count);
        crc = crc32(part, count, crc);
    }
    return crc == head.checksum;
}

template <Board B>
std::uint32_t load_flag(B& board, const Store& store, int at, Flag flag) {
    return load_words<std::uint32_t>(board, at + flag_at(store, flag));
}
template <Board B>
void set_flag(B& board, const Store& store, int at, Flag flag) {
    program_words(board, at + flag_at(store, flag), std::uint32_t(0));
}

template <Board B>
void make_certain(B& board, const Store& store, int at) {
    set_flag(board, store, at, Flag::written), set_flag(board, store, at, Flag::certain);
}

/// Whether the record at an address is valid; an invalid record is erased.
template <Board B>
bool is_valid(B& board, const Store& store, const Head& head, int at) {
    if (head == blank_head) return false;
    const std::uint32_t spoiled = load_flag(board, store, at, Flag::is_void);
    const bool certain = load_flag(board, store, at, Flag::certain) == 0;
    if (!certain && spoiled == 0) return false;
    const bool written = load_flag(board, store, at, Flag::written) == 0 && is_whole(board, store, head, at);
    const bool valid = written && (certain || spoiled == ~0u);
    if (!valid) set_flag(board, store, at, Flag::is_void);
    return valid;
}

/// Read the data of the valid record into `stored`. Return false, and leave `stored` unchanged, if no record is valid.
template <Board B>
bool open(Store& store, std::uint8_t* stored, B& board) {
    store.step = store.kept = store.slot = -1, store.sector = 0, store.again = store.failed = false, store.turn = 0;
    int valid = 0;
    for (int sector = 0; sector < 2; ++sector)
        for (int slot = 0; slot < records(store); ++slot) {
            const int at = address(store, sector, slot);
            const Head head = load_words<Head>(board, at);
            if (!is_valid(board, store, head, at)) continue;
            // Turns wrap: the later one is less than half a round ahead.
            if (0 <= store.kept && std::int32_t(head.turn - store.turn) < 0) continue;
            store.turn = head.turn, store.kept = sector, valid = at;
        }
    if (store.kept < 0) return false;
    make_certain(board, store, valid);
    board.load(valid + piece, stored, store.size);
    return true;
}

/// Begin to write the data, which has changed.
inline void begin_write(Store& store) {
    if (store.step < 0)
        store.step = 0;
    else
        store.again = true;
}

/// Whether the data is in the memory.
inline bool settled(const Store& store) { return store.step < 0; }

/// Begin a record in the next free slot or, erased, in the sector without the valid record.
template <Board B>
void begin_record(Store& store, const std::uint8_t* stored, B& board) {
    store.again = false;
    if (0 <= store.slot) ++store.slot;
    if (store.slot < 0 || store.slot == records(store)) {
        store.sector = store.kept == 0, store.slot = 0;
        board.erase(store.base + store.sector);
    }
    store.head = {store.layout, store.turn + 1, 0};
    store.head.checksum = crc32(stored, store.size, checksum(store.head));
}

/// Whether the record at an address is the one that was written.
template <Board B>
bool is_written(Store& store, B& board, int at) {
    const Head head = load_words<Head>(board, at);
    return head.turn == store.head.turn && head.checksum == store.head.checksum && is_whole(board, store, head, at);
}

/// End a write. A record that is not valid means that the sector does not hold data: it is erased before the next
/// record.
inline void end_write(Store& store, bool valid) {
    store.failed = !valid;
    if (valid) store.turn = store.head.turn, store.kept = store.sector;
    if (!valid) store.slot = -1;
    store.step = store.again ? 0 : -1;
}

/// Do the next operation of a write: erase, data piece by piece, head, flags. The write restarts in another slot if the
/// data changes before the flags.
template <Board B>
void write_some(Store& store, const std::uint8_t* stored, B& board) {
    if (store.step < 0) return;
    const int pieces = (store.size + piece - 1) / piece, flags = pieces + 2;
    if (store.again && store.step <= flags) store.step = 0;
    const int at = address(store, store.sector, store.slot), step = store.step++, from = (step - 1) * piece;
    if (step == 0) {
        begin_record(store, stored, board);
    } else if (step <= pieces) {
        board.program(at + piece + from, stored + from, store.size - from < piece ? store.size - from : piece);
    } else if (step == pieces + 1) {
        program_words(board, at, store.head);
    } else if (step == flags) {
        if (!is_written(store, board, at)) return end_write(store, false);
        set_flag(board, store, at, Flag::written);
    } else {
        set_flag(board, store, at, Flag::certain);
        end_write(store,
                  (load_flag(board, store, at, Flag::written) | load_flag(board, store, at, Flag::certain)) == 0);
    }
}

// --- witness: proof that there once was a valid record

inline constexpr int witnesses = 8;  // number of copies, a page each
inline constexpr std::uint32_t witness_words[4] = {0x6e757448, 0x6b657973, 0x91a3c5e7, 0x2468ace1};

/// Number of complete copies of the witness.
template <Board B>
int count_witnesses(B& board, int sector) {
    int count = 0;
    for (int k = 0; k < witnesses; ++k) {
        std::uint8_t copy[sizeof(witness_words)];
        board.load(sector * flash_sector + k * flash_page, copy, int(sizeof(copy)));
        count += std::memcmp(copy, witness_words, sizeof(copy)) == 0;
    }
    return count;
}

/// Write the missing copies of the witness, after the record is valid. Return whether all are there.
template <Board B>
bool bear_witness(B& board, int sector) {
    if (count_witnesses(board, sector) == witnesses) return true;
    board.erase(sector);
    for (int k = 0; k < witnesses; ++k) program_words(board, sector * flash_sector + k * flash_page, witness_words);
    return count_witnesses(board, sector) == witnesses;
}

}  // namespace hypertuna::firmware
