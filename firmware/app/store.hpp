/// Store: parameters in non-volatile memory, in two slots that are written in turn.
///
/// A slot is valid if mark, layout and checksum are right; of two valid ones the later counts. Writing a slot first
/// spoils its mark, then writes what it holds, then its checksum, then the mark: wherever the power goes, the
/// other slot is whole. A few bytes are written per tick, so that no tick waits for the memory.
#pragma once

#include <cstring>

#include "board.hpp"

namespace hypertuna::firmware {

/// CRC-32 (IEEE 802.3, reflected) of some bytes, on from an earlier one.
inline std::uint32_t crc32(const std::uint8_t* from, int count, std::uint32_t crc = 0) {
    crc = ~crc;
    for (int k = 0; k < count; ++k) {
        crc ^= from[k];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return ~crc;
}

inline constexpr std::uint32_t slot_mark = 0x6e757448;  // "Htun"
inline constexpr int slot_head = 16;                    // mark, layout, turn, checksum: four words
inline constexpr int most_kept = 512;                   // bytes that a slot holds
inline constexpr int slot_size = slot_head + most_kept;
inline constexpr int bytes_per_tick = 8;

/// What is being written.
struct Store {
    std::uint8_t kept[most_kept];  // what the memory should hold
    int size;                      // of that
    std::uint32_t layout, turn;    // turn: counts the writes; its lowest bit is the slot
    int step;                      // of the write, -1 when there is none
    bool again;                    // `kept` changed meanwhile
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
    const int base = slot * slot_size;
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

/// Read what is stored into `kept`. False, and `kept` as it was, where there is nothing valid.
template <Board B>
bool open(Store& store, B& board) {
    store.step = -1, store.again = false, store.turn = 0;
    std::uint32_t turn[2] = {0, 0};
    const bool valid[2] = {slot_valid(board, store, 0, turn[0]), slot_valid(board, store, 1, turn[1])};
    if (!valid[0] && !valid[1]) return false;
    // Turns wrap: the later one is less than half a round ahead.
    const int slot = !valid[0] ? 1 : !valid[1] ? 0 : std::int32_t(turn[1] - turn[0]) > 0 ? 1 : 0;
    store.turn = turn[slot];
    for (int k = 0; k < store.size; ++k) store.kept[k] = board.load(slot * slot_size + slot_head + k);
    return true;
}

/// `kept` changed: write it.
inline void keep(Store& store) {
    if (store.step < 0)
        store.step = 0;
    else
        store.again = true;
}

/// Whether everything that was kept is in the memory.
inline bool settled(const Store& store) { return store.step < 0; }

/// Write the next byte: four of a spoiled mark, what is held, the rest of the head, and the mark last.
template <Board B>
void write_next(Store& store, B& board) {
    if (store.step == 0) {
        store.again = false;
        const std::uint32_t turn = store.turn + 1, words[3] = {slot_mark, store.layout, turn};
        std::memcpy(store.head, words, 12);
        const std::uint32_t crc = checksum(store.head, store.kept, store.size);
        std::memcpy(store.head + 12, &crc, 4);
    }
    const int base = int(word_at(store.head + 8) & 1) * slot_size, step = store.step++;
    if (step < 4)
        board.save(base + step, 0);
    else if (step < 4 + store.size)
        board.save(base + slot_head + step - 4, store.kept[step - 4]);
    else if (step < 16 + store.size)
        board.save(base + 4 + step - 4 - store.size, store.head[4 + step - 4 - store.size]);
    else
        board.save(base + step - 16 - store.size, store.head[step - 16 - store.size]);
    if (store.step < slot_head + 4 + store.size) return;
    store.turn = word_at(store.head + 8);
    store.step = store.again ? 0 : -1;
}

/// Once a tick: write some bytes. What changed since the write began spoils it, and it begins anew.
template <Board B>
void write_some(Store& store, B& board) {
    if (store.again) store.step = 0;
    for (int k = 0; k < bytes_per_tick && store.step >= 0; ++k) write_next(store, board);
}

}  // namespace hypertuna::firmware
