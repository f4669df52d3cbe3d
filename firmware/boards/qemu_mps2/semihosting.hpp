/// Semihosting: calls that the emulator answers (ARM IHI 0056).
#pragma once

#include <cstddef>
#include <cstdint>

namespace hypertuna::firmware::semihosting {

inline int call(int operation, const void* arguments) {
    register int r0 asm("r0") = operation;
    register const void* r1 asm("r1") = arguments;
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

enum class Access : int { read = 1, write = 5 };  // "rb", "wb"

inline int open(const char* path, int length, Access access) {
    const std::intptr_t arguments[3] = {std::intptr_t(path), int(access), length};
    return call(0x01, arguments);
}

/// Read or write bytes, and return the number of those that were not read or written.
inline int read(int file, void* to, std::size_t count) {
    const std::intptr_t arguments[3] = {file, std::intptr_t(to), std::intptr_t(count)};
    return call(0x06, arguments);
}
inline int write(int file, const void* from, std::size_t count) {
    const std::intptr_t arguments[3] = {file, std::intptr_t(from), std::intptr_t(count)};
    return call(0x05, arguments);
}

/// End the emulation.
[[noreturn]] inline void exit(int status) {
    const std::intptr_t arguments[2] = {0x20026, status};  // ADP_Stopped_ApplicationExit
    call(0x20, arguments);
    for (;;) {
    }
}

}  // namespace hypertuna::firmware::semihosting
