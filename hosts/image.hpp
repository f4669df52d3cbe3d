/// Robot image: all columns of a robot that the core needs, in one file that any host can read.
///
/// Little-endian. A header of 32 bytes (magic, version, checksum, sizes), rows, width and length of the name of each
/// column, the names one after another, a text for the host, and, from a multiple of 8 on, the numbers.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "hypertuna/host/columns.hpp"
#include "ranges.hpp"

namespace hypertuna {

static_assert(std::endian::native == std::endian::little, "images are read where numbers are little-endian");

/// CRC-32 (IEEE 802.3), the same as zlib's.
inline std::uint32_t crc32(const unsigned char* bytes, std::size_t size) {
    std::uint32_t crc = ~0u;
    for (std::size_t k = 0; k < size; ++k) {
        crc ^= bytes[k];
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

struct ImageHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t checksum;  // CRC-32 of all bytes after this field
    std::uint32_t columns, names, text, numbers;
};
static_assert(sizeof(ImageHeader) == 32);

inline constexpr char image_magic[8] = {'H', 'T', 'R', 'O', 'B', 'O', 'T', '\0'};

/// The columns of an image and its text. Columns point into `numbers`.
struct Image {
    NamedColumns columns;
    std::vector<double> numbers;
    std::string text;  // JSON: names of robot, joints and gaits, which the core does not need

    /// Columns whose names begin with a prefix, with that prefix removed.
    NamedColumns part(const std::string& prefix) const {
        NamedColumns out;
        for (const NamedColumn& column : columns)
            if (column.name.starts_with(prefix))
                out.push_back({column.name.substr(prefix.size()), column.data, column.rows, column.width});
        return out;
    }
};

/// Read an image; a fault in it comes back as a sentence.
inline Loaded<Image> read_image(const unsigned char* bytes, std::size_t size) {
    using Entry = std::array<std::uint32_t, 3>;  // rows, width, length of the name
    const auto refused = [](const char* sentence) { return Loaded<Image>{std::nullopt, sentence}; };
    ImageHeader header;
    if (size < sizeof(header)) return refused("image: is shorter than a header; write it again");
    std::memcpy(&header, bytes, sizeof(header));
    if (std::memcmp(header.magic, image_magic, sizeof(image_magic)) != 0)
        return refused("image: is not a robot image; write one with `hypertuna robot image`");
    if (header.version != image_version)
        return {std::nullopt, "image: has version " + std::to_string(header.version) + ", but must have version " +
                                  std::to_string(image_version) + "; write it with this version of hypertuna"};
    const std::uint64_t entries = std::uint64_t(header.columns) * sizeof(Entry);
    const std::uint64_t before = sizeof(header) + entries + header.names + header.text, start = (before + 7) / 8 * 8;
    if (size != start + 8 * std::uint64_t(header.numbers)) return refused("image: is cut off or has bytes too many");
    constexpr std::size_t covered = offsetof(ImageHeader, columns);
    if (header.checksum != crc32(bytes + covered, size - covered))
        return refused("image: is damaged, since its checksum does not agree; write it again");
    Image image;
    image.numbers.resize(header.numbers);
    std::memcpy(image.numbers.data(), bytes + start, 8 * image.numbers.size());
    const char* const names = reinterpret_cast<const char*>(bytes + sizeof(header) + entries);
    image.text.assign(names + header.names, header.text);
    const auto printable = [](char c) { return '!' <= c && c <= '~'; };
    if (!std::all_of(names, names + header.names, printable))
        return refused("image: has names of columns that are not plain; write it again");
    std::uint64_t name = 0, number = 0;
    for (std::uint32_t k = 0; k < header.columns; ++k) {
        Entry entry;
        std::memcpy(&entry, bytes + sizeof(header) + k * sizeof(entry), sizeof(entry));
        const auto [rows, width, length] = entry;
        const std::uint64_t count = std::uint64_t(rows) * width;
        if (length > header.names - name || count > header.numbers - number || std::max(rows, width) > header.numbers)
            return refused("image: has columns beyond its end; write it again");
        image.columns.push_back({std::string(names + name, length), image.numbers.data() + number, rows, width});
        const NamedColumn& column = image.columns.back();
        const NumberRange& range = range_of(column.name);
        for (std::uint64_t i = 0; i < count; ++i)
            if (!in_range(range, column.data[i]))
                return {std::nullopt, out_of_range(column.name, range, column.data[i])};
        name += length;
        number += count;
    }
    return {std::move(image), {}};
}

}  // namespace hypertuna
