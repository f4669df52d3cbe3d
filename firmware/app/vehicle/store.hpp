/// Store: something that lasts, in two slots of non-volatile memory that are written in turn.
///
/// A slot is valid if mark, layout and checksum are right; of two valid ones the later counts. Writing a slot first
/// spoils its mark, then writes what it holds, then its checksum, then the mark: wherever the power goes, the
/// other slot is whole. A few bytes change per tick, so that no tick waits for the memory; in the end the slot is read
/// back.
#pragma once

#include <cstring>

#include "app/board.hpp"

namespace hypertuna::firmware {

/// CRC-32 (IEEE 802.3, reflected) of some bytes, on from an earlier one, half a byte at a time.
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

inline constexpr std::uint32_t slot_mark = 0x6e757448;             // "Htun"
inline constexpr int slot_head = 16;                               // mark, layout, turn, checksum: four words
inline constexpr int changed_per_tick = 8, written_per_tick = 64;  // bytes at most

/// Where something is kept, and how far its writing is. What is kept itself lies elsewhere, in `size` bytes.
struct Store {
    int base, size;                // address of the first slot; bytes of what is kept
    std::uint32_t layout, turn;    // turn: counts the writes; its lowest bit is the slot
    int step;                      // of the write, -1 when there is none
    bool again, failed;            // it changed meanwhile; what was read back last was not what was written
    std::uint8_t head[slot_head];  // of the slot that is being written
};

inline std::uint32_t word_at(const std::uint8_t* from) {
    std::uint32_t word;
    std::memcpy(&word, from, 4);
    return word;
}

template <Board B>
std::uint32_t load_word(B& board, int address) {
    std::uint32_t word = 0;
    for (int k = 0; k < 4; ++k) word |= std::uint32_t(board.load(address + k)) << 8 * k;
    return word;
}

/// The checksum of a slot covers layout, turn and what it holds.
inline std::uint32_t checksum(const std::uint8_t* head, const std::uint8_t* kept, int size) {
    return crc32(kept, size, crc32(head + 4, 8));
}

/// Whether a slot is valid; then its turn.
template <Board B>
bool slot_valid(B& board, const Store& store, int slot, std::uint32_t& turn) {
    const int base = store.base + slot * (slot_head + store.size);
    if (load_word(board, base) != slot_mark || load_word(board, base + 4) != store.layout) return false;
    std::uint32_t crc = 0;
    for (int k = 4; k < slot_head + store.size; ++k) {
        if (k == 12) k = slot_head;  // not over itself
        const std::uint8_t byte = board.load(base + k);
        crc = crc32(&byte, 1, crc);
    }
    turn = load_word(board, base + 8);
    return crc == load_word(board, base + 12);
}

/// Read what is stored. False, and `kept` as it was, where there is nothing valid.
template <Board B>
bool open(Store& store, std::uint8_t* kept, B& board) {
    store.step = -1, store.again = store.failed = false, store.turn = 0;
    std::uint32_t turn[2] = {0, 0};
    const bool valid[2] = {slot_valid(board, store, 0, turn[0]), slot_valid(board, store, 1, turn[1])};
    if (!valid[0] && !valid[1]) return false;
    // Turns wrap: the later one is less than half a round ahead.
    const int slot = !valid[0] ? 1 : !valid[1] ? 0 : std::int32_t(turn[1] - turn[0]) > 0 ? 1 : 0;
    store.turn = turn[slot];
    const int from = store.base + slot * (slot_head + store.size) + slot_head;
    for (int k = 0; k < store.size; ++k) kept[k] = board.load(from + k);
    return true;
}

/// What is kept changed: write it.
inline void keep(Store& store) {
    if (store.step < 0)
        store.step = 0;
    else
        store.again = true;
}

/// Whether everything that was kept is in the memory.
inline bool settled(const Store& store) { return store.step < 0; }

/// The slot is written: the other one is the next, if this one holds.
template <Board B>
void end_write(Store& store, B& board) {
    const std::uint32_t turn = word_at(store.head + 8);
    std::uint32_t found = 0;
    store.failed = !slot_valid(board, store, int(turn & 1), found);
    if (!store.failed) store.turn = turn;
    store.step = store.again ? 0 : -1;
}

/// Write the next byte: four of a spoiled mark, what is kept, the rest of the head, and the mark last. Whether it
/// changed.
template <Board B>
bool write_next(Store& store, const std::uint8_t* kept, B& board) {
    if (store.step == 0) {
        store.again = false;
        const std::uint32_t turn = store.turn + 1, words[3] = {slot_mark, store.layout, turn};
        std::memcpy(store.head, words, 12);
        const std::uint32_t crc = checksum(store.head, kept, store.size);
        std::memcpy(store.head + 12, &crc, 4);
    }
    const int base = store.base + int(word_at(store.head + 8) & 1) * (slot_head + store.size), step = store.step++;
    const int head = step - store.size;  // of the head, from its second word on, then its first
    const bool spoils = step < 4, body = !spoils && step < 4 + store.size;
    const int at = spoils ? step : body ? slot_head + step - 4 : head < slot_head ? head : head - slot_head;
    const std::uint8_t byte = spoils ? 0 : body ? kept[step - 4] : store.head[at];
    const bool changes = board.load(base + at) != byte;
    board.save(base + at, byte);
    if (store.step == slot_head + 4 + store.size) end_write(store, board);
    return changes;
}

/// Once a tick: write some bytes. What changed since the write began spoils it, and it begins anew.
template <Board B>
void write_some(Store& store, const std::uint8_t* kept, B& board) {
    if (store.again) store.step = 0;
    int changed = 0;
    for (int k = 0; k < written_per_tick && changed < changed_per_tick && store.step >= 0; ++k)
        changed += write_next(store, kept, board);
}

}  // namespace hypertuna::firmware
