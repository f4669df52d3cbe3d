/// Store: data in two slots of non-volatile memory that are written in turn.
///
/// A slot is valid if mark, layout and checksum are right; of two valid slots the later counts. A write first destroys
/// the slot's mark, then writes the data, the checksum, and the mark last: whenever the power fails, the other slot is
/// intact. A few bytes are written per tick, so that no tick waits for the memory; then the slot is read back.
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

inline constexpr std::uint32_t slot_mark = 0x6e757448;             // "Htun"
inline constexpr int slot_head = 16;                               // mark, layout, turn, checksum: four words
inline constexpr int changed_per_tick = 8, written_per_tick = 64;  // bytes at most

/// Place of the slots, and progress of the write. The data itself lies elsewhere, in `size` bytes.
struct Store {
    int base, size;                // address of the first slot; bytes of data
    std::uint32_t layout, turn;    // turn: number of writes; its lowest bit is the slot
    int step;                      // of the write, -1 if there is none
    bool again, failed;            // the data changed during the write; the last slot was read back wrong
    std::uint8_t head[slot_head];  // of the slot being written
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

/// Checksum of a slot: layout, turn and data.
inline std::uint32_t checksum(const std::uint8_t* head, const std::uint8_t* stored, int size) {
    return crc32(stored, size, crc32(head + 4, 8));
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

/// Read the data. False, and `stored` unchanged, if no slot is valid.
template <Board B>
bool open(Store& store, std::uint8_t* stored, B& board) {
    store.step = -1, store.again = store.failed = false, store.turn = 0;
    std::uint32_t turn[2] = {0, 0};
    const bool valid[2] = {slot_valid(board, store, 0, turn[0]), slot_valid(board, store, 1, turn[1])};
    if (!valid[0] && !valid[1]) return false;
    // Turns wrap: the later one is less than half a round ahead.
    const int slot = !valid[0] ? 1 : !valid[1] ? 0 : std::int32_t(turn[1] - turn[0]) > 0 ? 1 : 0;
    store.turn = turn[slot];
    const int from = store.base + slot * (slot_head + store.size) + slot_head;
    for (int k = 0; k < store.size; ++k) stored[k] = board.load(from + k);
    return true;
}

/// The data changed: write it.
inline void begin_write(Store& store) {
    if (store.step < 0)
        store.step = 0;
    else
        store.again = true;
}

/// Whether the data is in the memory.
inline bool settled(const Store& store) { return store.step < 0; }

/// The slot is written: read it back; the other slot is next if it is right.
template <Board B>
void end_write(Store& store, B& board) {
    const std::uint32_t turn = word_at(store.head + 8);
    std::uint32_t stored_turn = 0;
    store.failed = !slot_valid(board, store, int(turn & 1), stored_turn);
    if (!store.failed) store.turn = turn;
    store.step = store.again ? 0 : -1;
}

/// Write the next byte: four zeros over the mark, the data, the rest of the head, and the mark last. Return whether the
/// byte changed.
template <Board B>
bool write_next(Store& store, const std::uint8_t* stored, B& board) {
    if (store.step == 0) {
        store.again = false;
        const std::uint32_t turn = store.turn + 1, words[3] = {slot_mark, store.layout, turn};
        std::memcpy(store.head, words, 12);
        const std::uint32_t crc = checksum(store.head, stored, store.size);
        std::memcpy(store.head + 12, &crc, 4);
    }
    const int base = store.base + int(word_at(store.head + 8) & 1) * (slot_head + store.size), step = store.step++;
    const int head = step - store.size;  // of the head, from its second word on, then its first
    const bool spoils = step < 4, body = !spoils && step < 4 + store.size;
    const int at = spoils ? step : body ? slot_head + step - 4 : head < slot_head ? head : head - slot_head;
    const std::uint8_t byte = spoils ? 0 : body ? stored[step - 4] : store.head[at];
    const bool changes = board.load(base + at) != byte;
    board.save(base + at, byte);
    if (store.step == slot_head + 4 + store.size) end_write(store, board);
    return changes;
}

/// Once a tick: write some bytes. The write restarts if the data changed meanwhile.
template <Board B>
void write_some(Store& store, const std::uint8_t* stored, B& board) {
    if (store.again) store.step = 0;
    int changed = 0;
    for (int k = 0; k < written_per_tick && changed < changed_per_tick && store.step >= 0; ++k)
        changed += write_next(store, stored, board);
}

}  // namespace hypertuna::firmware
