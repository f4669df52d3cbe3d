/// Counts what a test allocates; for one source file of a program.
#pragma once

#include <cstdlib>
#include <new>

#include "hypertuna/math/scalar.hpp"

static int allocations = 0;

// Not inlined: else the compiler sees new paired with free and warns.
HYPERTUNA_NOINLINE void* operator new(std::size_t size) {
    ++allocations;
    return std::malloc(size);
}
HYPERTUNA_NOINLINE void* operator new(std::size_t size, std::align_val_t alignment) {
    ++allocations;
    return std::aligned_alloc(std::size_t(alignment), size);
}
HYPERTUNA_NOINLINE void operator delete(void* p) noexcept { std::free(p); }
HYPERTUNA_NOINLINE void operator delete(void* p, std::size_t) noexcept { std::free(p); }
HYPERTUNA_NOINLINE void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
