/// Black box: one record per tick, written to a ring in memory and from there to the board's card.
///
/// A record is a row of little-endian words: a mark with kind and number of words, the words, and the sum of the
/// words' partial sums as a checksum. After a gap a reader finds the next record by its mark.
#pragma once

#include <bit>

#include "app/board.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint32_t record_mark = 0xb10c0000;  // | kind << 8 | words
inline constexpr std::uint32_t ring_words = 1 << 11;      // a third of a second of a robot with two joints

/// Kind of a record.
enum class Kind : std::uint8_t { robot = 1, tick = 2 };

struct BlackBox {
    std::uint32_t ring[ring_words];
    std::uint32_t in, out;  // words written, words passed on
    std::uint32_t lost;     // records dropped because the ring was full
    bool full;              // the record being written does not fit
};

/// A record being written into the ring.
class Record {
  public:
    Record(BlackBox& box, Kind kind) : box_(box), begin_(box.in), kind_(kind) {
        box_.full = false;
        put(std::uint32_t(0));
    }
    void put(std::uint32_t word) {
        if (box_.in - box_.out >= ring_words) {
            box_.full = true;
            return;
        }
        box_.ring[box_.in++ % ring_words] = word;
    }
    void put(float number) { put(std::bit_cast<std::uint32_t>(number)); }
    void put(const float* numbers, int count) {
        for (int k = 0; k < count; ++k) put(numbers[k]);
    }
    /// Complete the record, or drop it if it does not fit.
    void end() {
        if (!box_.full) {
            const std::uint32_t words = box_.in - begin_ - 1;
            box_.ring[begin_ % ring_words] = record_mark | std::uint32_t(kind_) << 8 | words;
            std::uint32_t sum = 0, sums = 0;
            for (std::uint32_t k = begin_; k != box_.in; ++k) sum += box_.ring[k % ring_words], sums += sum;
            put(sums);
        }
        if (!box_.full) return;
        box_.in = begin_;
        ++box_.lost;
    }

  private:
    BlackBox& box_;
    std::uint32_t begin_;
    Kind kind_;
};

/// Pass on what the board accepts, in one piece per tick and in whole words.
template <Board B>
void flush(BlackBox& box, B& board) {
    const std::uint32_t at = box.out % ring_words, waiting = box.in - box.out;
    const std::uint32_t piece = waiting < ring_words - at ? waiting : ring_words - at;
    if (piece == 0) return;
    const auto* from = reinterpret_cast<const std::uint8_t*>(box.ring + at);
    box.out += std::uint32_t(board.log(from, int(4 * piece))) / 4;
}

}  // namespace hypertuna::firmware
