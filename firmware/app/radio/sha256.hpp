/// SHA-256 (FIPS 180-4), for signatures of frames.
#pragma once

#include <cstdint>

namespace hypertuna::firmware {

struct Sha256 {
    std::uint32_t word[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                             0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::uint8_t block[64] = {};
    std::uint32_t length = 0;  // bytes so far
};

inline constexpr std::uint32_t sha256_round[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

inline std::uint32_t turned(std::uint32_t x, int by) { return x >> by | x << (32 - by); }

/// Mix a whole block into the hash. The message schedule is kept for sixteen rounds at a time.
inline void compress(Sha256& hash) {
    std::uint32_t w[16], s[8];
    for (int k = 0; k < 16; ++k)
        w[k] = std::uint32_t(hash.block[4 * k]) << 24 | std::uint32_t(hash.block[4 * k + 1]) << 16 |
               std::uint32_t(hash.block[4 * k + 2]) << 8 | hash.block[4 * k + 3];
    for (int k = 0; k < 8; ++k) s[k] = hash.word[k];
    for (int k = 0; k < 64; ++k) {
        const std::uint32_t sum = turned(s[4], 6) ^ turned(s[4], 11) ^ turned(s[4], 25);
        const std::uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
        const std::uint32_t first = s[7] + sum + choice + sha256_round[k] + w[k & 15];
        const std::uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
        const std::uint32_t second = (turned(s[0], 2) ^ turned(s[0], 13) ^ turned(s[0], 22)) + majority;
        for (int i = 7; i > 0; --i) s[i] = s[i - 1];
        s[4] += first, s[0] = first + second;
        const std::uint32_t a = w[(k + 1) & 15], b = w[(k + 14) & 15];
        w[k & 15] +=
            (turned(a, 7) ^ turned(a, 18) ^ a >> 3) + w[(k + 9) & 15] + (turned(b, 17) ^ turned(b, 19) ^ b >> 10);
    }
    for (int k = 0; k < 8; ++k) hash.word[k] += s[k];
}

inline void add(Sha256& hash, const std::uint8_t* bytes, int count) {
    for (int k = 0; k < count; ++k) {
        hash.block[hash.length++ & 63] = bytes[k];
        if ((hash.length & 63) == 0) compress(hash);
    }
}

/// Write the first `count` bytes of the digest of all bytes added.
inline void finish(Sha256& hash, std::uint8_t* digest, int count) {
    const std::uint32_t bytes = hash.length;
    const std::uint8_t end = 0x80, zero = 0;
    add(hash, &end, 1);
    while ((hash.length & 63) != 56) add(hash, &zero, 1);
    const std::uint8_t bits[8] = {0,
                                  0,
                                  0,
                                  std::uint8_t(bytes >> 29),
                                  std::uint8_t(bytes >> 21),
                                  std::uint8_t(bytes >> 13),
                                  std::uint8_t(bytes >> 5),
                                  std::uint8_t(bytes << 3)};
    add(hash, bits, 8);
    for (int k = 0; k < count; ++k) digest[k] = std::uint8_t(hash.word[k / 4] >> (24 - 8 * (k % 4)));
}

}  // namespace hypertuna::firmware
