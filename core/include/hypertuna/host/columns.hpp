/// Named columns of numbers: how every description enters the core, from Python, from a file or through C.
///
/// A loader reads the columns that it knows by name and ignores the others. What is wrong with them comes back as a
/// sentence; there are no exceptions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna {

/// Version of the robot images that carry columns to other hosts: it changes whenever columns come, go or change.
inline constexpr std::uint32_t image_version = 6;

/// Numbers of shape (rows, width), row by row, in memory that the column does not own.
struct NamedColumn {
    std::string name;
    const double* data;
    std::size_t rows, width;
};
using NamedColumns = std::vector<NamedColumn>;

/// What a loader returns: an object, or a sentence that says what is wrong with its columns.
template <class T>
struct Loaded {
    std::optional<T> object;
    std::string fault;
};

/// Reads columns by name and keeps the first fault; after one it goes on with zeros.
class ColumnReader {
  public:
    explicit ColumnReader(const NamedColumns& columns) : columns_(columns) {}

    /// Empty where nothing is wrong.
    const std::string& fault() const { return fault_; }
    void refuse(const std::string& sentence) {
        if (fault_.empty()) fault_ = sentence;
    }

    /// A column, or null.
    const NamedColumn* find(const std::string& name) const {
        for (const NamedColumn& column : columns_)
            if (column.name == name) return &column;
        return nullptr;
    }
    bool has(const std::string& name) const { return find(name) != nullptr; }

    /// All numbers of a column of this shape.
    std::vector<double> numbers(const std::string& name, std::size_t rows, std::size_t width = 1) {
        const NamedColumn* const column = required(name);
        if (column && (column->rows != rows || column->width != width))
            refuse(name + ": shape must be " + shape(rows, width) + ", but is " + shape(column->rows, column->width));
        if (!column || !fault_.empty()) return std::vector<double>(rows * width);
        return {column->data, column->data + rows * width};
    }
    /// One number of a column.
    double number(const std::string& name, std::size_t index = 0) {
        const NamedColumn* const column = required(name);
        if (!column) return 0;
        if (index < column->rows * column->width) return column->data[index];
        refuse(name + ": must have " + std::to_string(index + 1) + " numbers or more, but has " +
               std::to_string(column->rows * column->width));
        return 0;
    }
    /// A whole number from `low` to `high`.
    int whole(const std::string& name, int low, int high) {
        const double value = number(name);
        if (low <= value && value <= high) return int(value);
        refuse(name + ": must be from " + std::to_string(low) + " to " + std::to_string(high));
        return low;
    }
    /// The row of an object whose numbers are named by `names`, each a column `prefix.name` with one number per object.
    template <std::size_t N>
    std::vector<double> row(const std::string& prefix, const char* const (&names)[N], std::size_t index = 0) {
        std::vector<double> out;
        for (const char* name : names) out.push_back(number(prefix + "." + name, index));
        return out;
    }

    template <class T>
    Loaded<T> loaded(T&& object) {
        if (!fault_.empty()) return {std::nullopt, fault_};
        return {std::move(object), {}};
    }

  private:
    const NamedColumn* required(const std::string& name) {
        const NamedColumn* const column = find(name);
        if (!column) refuse("columns: lacks " + name);
        return column;
    }
    static std::string shape(std::size_t rows, std::size_t width) {
        return std::string("(").append(std::to_string(rows)).append(", ").append(std::to_string(width)).append(")");
    }

    const NamedColumns& columns_;
    std::string fault_;
};

}  // namespace hypertuna
