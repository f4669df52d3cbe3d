/// NumPy arrays as arguments and results.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <initializer_list>

#include "hypertuna/host/columns.hpp"

namespace hypertuna {

namespace nb = nanobind;

template <int Dimensions>
using Input = nb::ndarray<const double, nb::ndim<Dimensions>, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<nb::numpy, double>;
using NamedArrays = nb::typed<nb::dict, nb::str, Output>;

/// A new array of zeros that Python owns.
inline Output zeros(std::initializer_list<std::size_t> shape) {
    std::size_t size = 1;
    for (std::size_t extent : shape) size *= extent;
    auto* data = new double[std::max<std::size_t>(size, 1)]();
    nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return Output(data, shape.size(), shape.begin(), owner);
}

/// Check of an array's shape: the array `name` must have this extent along an axis.
inline void check_extent(const char* name, std::size_t got, std::size_t wanted) {
    if (got != wanted)
        throw nb::value_error(
            (std::string(name) + ": extent must be " + std::to_string(wanted) + ", but is " + std::to_string(got))
                .c_str());
}

/// Raise a fault that a loader or a check of the core returned.
inline void check(const std::string& fault) {
    if (!fault.empty()) throw nb::value_error(fault.c_str());
}
template <class T>
T take(Loaded<T>&& loaded) {
    check(loaded.fault);
    return std::move(*loaded.object);
}

/// A mapping from names to arrays of one or two dimensions, lists of numbers, or numbers.
using Mapping = nb::typed<nb::dict, nb::str, nb::any>;

/// Columns of a mapping, and the memory of those that are not arrays.
struct MappedColumns {
    std::vector<std::vector<double>> lists;
    std::vector<nb::ndarray<const double, nb::c_contig, nb::device::cpu>> arrays;
    NamedColumns columns;

    explicit MappedColumns(const Mapping& mapping) {
        for (const auto& [key, value] : mapping) {
            const std::string name = nb::cast<std::string>(key);
            nb::ndarray<const double, nb::c_contig, nb::device::cpu> array;
            if (nb::try_cast(value, array) && array.ndim() >= 1 && array.ndim() <= 2) {
                columns.push_back({name, array.data(), array.shape(0), array.ndim() == 2 ? array.shape(1) : 1});
                arrays.push_back(array);
                continue;
            }
            std::vector<double> list(1);
            if (!nb::try_cast(value, list[0]) && !nb::try_cast(value, list))
                throw nb::value_error((name + ": must be an array of doubles, a list of numbers or a number").c_str());
            columns.push_back({name, list.data(), list.size(), 1});
            lists.push_back(std::move(list));
        }
    }
};

}  // namespace hypertuna
