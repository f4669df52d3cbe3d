/// NumPy arrays in and out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <initializer_list>

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

/// The one check of array shapes: what is called `name` must have this extent along an axis.
inline void check_extent(const char* name, std::size_t got, std::size_t wanted) {
    if (got != wanted)
        throw nb::value_error(
            (std::string(name) + ": extent must be " + std::to_string(wanted) + ", but is " + std::to_string(got))
                .c_str());
}

}  // namespace hypertuna
