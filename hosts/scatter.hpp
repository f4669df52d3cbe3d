/// Random scatter of a mission by its seed: a current and periods without satellites, drawn as in mission/file.py.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna {

/// NumPy's default_rng of two whole numbers: PCG64 (XSL RR 128/64), seeded by a SeedSequence of their 32-bit words.
class Random {
  public:
    Random(std::uint64_t first, std::uint32_t second) {
        std::vector<std::uint32_t> entropy{std::uint32_t(first)};
        if (first >> 32) entropy.push_back(std::uint32_t(first >> 32));
        entropy.push_back(second);
        std::uint32_t pool[4], times = 0x43b0d7e5;
        const auto hashed = [&](std::uint32_t word) {
            word ^= times;
            times *= 0x931e8875;
            word *= times;
            return word ^ word >> 16;
        };
        for (std::size_t k = 0; k < 4; ++k) pool[k] = hashed(k < entropy.size() ? entropy[k] : 0);
        for (int from = 0; from < 4; ++from)
            for (int to = 0; to < 4; ++to) {
                if (from == to) continue;
                const std::uint32_t mixed = 0xca01f9dd * pool[to] - 0x4973f715 * hashed(pool[from]);
                pool[to] = mixed ^ mixed >> 16;
            }
        std::uint64_t words[4] = {};
        times = 0x8b51f9dd;
        for (int k = 0; k < 8; ++k) {
            std::uint32_t word = pool[k % 4] ^ times;
            times *= 0x58f38ded;
            word *= times;
            words[k / 2] |= std::uint64_t(word ^ word >> 16) << 32 * (k % 2);
        }
        step_ = (Wide(words[2]) << 64 | words[3]) << 1 | 1;
        state_ = step_ + (Wide(words[0]) << 64 | words[1]);
        go();
    }

    /// Uniform number from 0 to 1, 1 excluded.
    double uniform() {
        go();
        const std::uint64_t bits = std::rotr(std::uint64_t(state_ >> 64) ^ std::uint64_t(state_), int(state_ >> 122));
        return double(bits >> 11) / 9007199254740992.0;
    }

  private:
    __extension__ using Wide = unsigned __int128;

    void go() { state_ = state_ * (Wide(0x2360ed051fc65da4) << 64 | 0x4385df649fccf645) + step_; }

    Wide state_, step_;
};

/// Ranges of a mission's random scatter.
struct Scatter {
    double current;  // m/s, largest added current, in any direction
    int gaps;        // periods without satellites
    double gap;      // s, longest duration of a gap
    double span;     // s from the start within which gaps begin
    std::uint32_t hash;

    /// Return the current toward east and north that a seed adds, and merge its gaps into `there`; seed 0 adds nothing.
    std::array<double, 2> add(std::uint64_t seed, std::vector<double>& there) const {
        if (seed == 0) return {0, 0};
        Random random(seed, hash);
        const double speed = current * random.uniform(), toward = 2 * pi * random.uniform();
        std::vector<std::pair<double, double>> pairs;
        for (std::size_t k = 0; k + 1 < there.size(); k += 2) pairs.emplace_back(there[k], there[k + 1]);
        const std::size_t first = pairs.size();
        for (int k = 0; k < gaps; ++k) pairs.emplace_back(span * random.uniform(), 0);
        for (std::size_t k = first; k < pairs.size(); ++k) pairs[k].second = pairs[k].first + gap * random.uniform();
        there.clear();
        while (!pairs.empty()) {  // gaps are few: a sort would take more code than it saves time
            const auto next = std::min_element(pairs.begin(), pairs.end());
            const auto [begin, end] = *next;
            *next = pairs.back();
            pairs.pop_back();
            if (!there.empty() && begin <= there.back())
                there.back() = std::max(there.back(), end);
            else if (begin < end)
                there.insert(there.end(), {begin, end});
        }
        return {speed * std::sin(toward), speed * std::cos(toward)};
    }
};

}  // namespace hypertuna
