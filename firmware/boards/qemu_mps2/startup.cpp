/// From reset to main: floating point on, data in place, and everything unexpected ends the emulation.
#include "semihosting.hpp"

using namespace hypertuna::firmware;

extern "C" {
extern std::uint32_t stack_top, stack_bottom, data_image, data_begin, data_end, bss_begin, bss_end;
extern void (*first_constructor)(), (*last_constructor)();
int main();

[[noreturn]] void fault() { semihosting::exit(70); }

[[noreturn]] void reset() {
    *reinterpret_cast<volatile std::uint32_t*>(0xe000ed88) |= 0xfu << 20;  // CPACR: the floating-point unit
    asm volatile("dsb\n isb");
    std::uint32_t* from = &data_image;
    for (std::uint32_t* to = &data_begin; to < &data_end;) *to++ = *from++;
    for (std::uint32_t* to = &bss_begin; to < &bss_end;) *to++ = 0;
    // Unused words of the stack keep this pattern.
    const std::uint32_t* here = static_cast<std::uint32_t*>(__builtin_frame_address(0)) - 16;
    for (std::uint32_t* to = &stack_bottom; to < here;) *to++ = 0xa5a5a5a5;
    for (void (**constructor)() = &first_constructor; constructor < &last_constructor;) (*constructor++)();
    semihosting::exit(main());
}

[[gnu::section(".vectors"), gnu::used]] void (*const vectors[16])() = {reinterpret_cast<void (*)()>(&stack_top),
                                                                       reset,
                                                                       fault,
                                                                       fault,
                                                                       fault,
                                                                       fault,
                                                                       fault,
                                                                       nullptr,
                                                                       nullptr,
                                                                       nullptr,
                                                                       nullptr,
                                                                       fault,
                                                                       fault,
                                                                       nullptr,
                                                                       fault,
                                                                       fault};
}
