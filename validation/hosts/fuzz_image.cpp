/// Damage a robot image many times, each with a good checksum; read it, and where it is accepted, swim a gait, run
/// twins and devices in the plane and at sea and fly a mission. What runs must stay finite, or say that it ended.
/// Prints how many were read: fuzz_image IMAGE COUNT [SEED] [numbers], with `numbers` of those damaged alone.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string_view>

#include "device.h"
#include "image.hpp"

using namespace hypertuna;

namespace {

using Bytes = std::vector<unsigned char>;

Bytes file(const char* name) {
    Bytes bytes;
    if (std::FILE* const from = std::fopen(name, "rb")) {
        for (int byte; (byte = std::fgetc(from)) != EOF;) bytes.push_back(static_cast<unsigned char>(byte));
        std::fclose(from);
    }
    return bytes;
}

struct Chance {
    std::mt19937_64 bits;

    std::size_t below(std::size_t count) { return bits() % count; }
    /// An odd number: one of those below, one of any size, or most often `was` by a factor.
    double number(double was) {
        constexpr double odd[] = {0,    -0.0, 1,    -1,      0.5,        1e-300,       1e300, -1e300, 5e-324,
                                  1e9,  -1e9, 255,  2.5,     2147483647, -2147483648., 4e9,   9.3e18, -9.3e18,
                                  1e19, 1e-9, 1e15, 1.7e308, HUGE_VAL,   -HUGE_VAL,    NAN};
        const std::size_t kind = below(4);
        if (kind == 0) return odd[below(std::size(odd))];
        const double sign = below(4) ? 1 : -1;
        return sign *
               (kind == 1 ? std::pow(10.0, double(below(40)) - 20) : was * std::pow(10.0, double(below(13)) - 6));
    }
};

/// Change numbers to odd ones, and unless only `numbers`, bytes anywhere behind the header's checksum, sizes in the
/// header and of columns; at times cut the end off.
void damage(Bytes& image, Chance& chance, bool only_numbers) {
    constexpr std::size_t body = offsetof(ImageHeader, columns);
    ImageHeader header;
    std::memcpy(&header, image.data(), sizeof(header));
    const std::size_t entries = sizeof(header), numbers = image.size() - 8 * std::size_t(header.numbers);
    for (std::size_t k = 1 + chance.below(3); k > 0; --k) {
        const std::size_t kind = chance.below(only_numbers ? 6 : 10);
        if (kind < 6) {
            unsigned char* const at = &image[numbers + 8 * chance.below(header.numbers)];
            double number;
            std::memcpy(&number, at, sizeof(number));
            number = chance.number(number);
            std::memcpy(at, &number, sizeof(number));
        } else if (kind < 8) {
            image[body + chance.below(image.size() - body)] = static_cast<unsigned char>(chance.below(256));
        } else if (kind < 9) {
            const std::uint32_t size = chance.below(2) ? std::uint32_t(chance.bits()) : std::uint32_t(chance.below(8));
            std::memcpy(&image[entries + 4 * chance.below(3 * std::size_t(header.columns))], &size, sizeof(size));
        } else {
            const std::uint32_t size = std::uint32_t(chance.bits());
            std::memcpy(&image[body + 4 * chance.below(4)], &size, sizeof(size));
        }
    }
    if (!only_numbers && chance.below(50) == 0)
        image.resize(sizeof(header) + chance.below(image.size() - sizeof(header)));
    const std::uint32_t checksum = crc32(image.data() + body, image.size() - body);
    std::memcpy(&image[offsetof(ImageHeader, checksum)], &checksum, sizeof(checksum));
}

/// Gait of 2 Hz with bends of 0.2 rad.
std::vector<double> gait_of(const ht_robot* robot) {
    const int groups = ht_robot_groups(robot);
    std::vector<double> gait(1 + 3 * groups);
    gait[0] = 2;
    for (int g = 0; g < groups; ++g) gait[1 + g] = 0.2, gait[1 + groups + g] = 0.5 * g;
    return gait;
}

bool finite(const std::vector<double>& row) {
    for (double number : row)
        if (!std::isfinite(number)) return false;
    return true;
}

/// Settle a gait, with its derivatives and path; whether what is settled is finite.
bool swim(const ht_robot* robot, int model, const std::vector<double>& gait) {
    int count = 0, slopes = 0;
    while (ht_quantity(count)) ++count;
    while (ht_derivative(slopes)) ++slopes;
    std::vector<double> quantities(count), derivatives(slopes * gait.size());
    std::vector<double> rows(9 * (4 + ht_robot_links(robot)));
    ht_swim(robot, model, gait.data(), 1, 0, quantities.data());
    ht_gradient(robot, model, gait.data(), derivatives.data());
    ht_path(robot, model, gait.data(), 8, rows.data());
    char text[400];
    ht_verdict(gait.data(), quantities.data(), text, sizeof(text));
    for (int k = 0; k < count; ++k)
        if (std::string_view(ht_quantity(k)) == "status" && quantities[k] != 0) return true;
    return std::isfinite(quantities[0]);
}

/// Functions of a twin, or of a device.
struct TwinCalls {
    static constexpr auto column = ht_twin_column;
    static constexpr auto command = ht_twin_command;
    static constexpr auto advance = ht_twin_advance;
    static constexpr auto read = ht_twin_read;
    static constexpr auto state_size = ht_twin_state_size;
    static constexpr auto save = ht_twin_save;
    static constexpr auto restore = ht_twin_restore;
    static constexpr auto free = ht_twin_free;
};
struct DeviceCalls {
    static constexpr auto column = ht_device_column;
    static constexpr auto command = ht_device_command;
    static constexpr auto advance = ht_device_advance;
    static constexpr auto read = ht_device_read;
    static constexpr auto state_size = ht_device_state_size;
    static constexpr auto save = ht_device_save;
    static constexpr auto restore = ht_device_restore;
    static constexpr auto free = ht_device_free;
};

struct Counts {
    long read, twins, flights, devices, silent, endless;  // refused without a sentence; not finite, and did not end
};

/// Run for 25 ticks, on a mission or under a command, and on from a state of its own.
template <class Calls, class Twin>
void run(Twin* twin, const std::vector<double>& gait, Counts& counts) {
    int numbers = 0;
    for (int k = 0, width = 0; Calls::column(twin, k, &width); ++k) numbers += width;
    std::vector<double> row(numbers);
    Bytes state(Calls::state_size(twin));
    const double fins[2] = {0.1, -0.1};
    Calls::command(twin, gait.data(), fins, 1);
    bool whole = true;
    for (int k = 0; k < 5; ++k) {
        whole = Calls::advance(twin, 5) == 5 && whole;
        Calls::read(twin, row.data());
        if (whole && !finite(row)) {
            std::size_t at = 0;
            for (int k = 0, width = 0; const char *name = Calls::column(twin, k, &width); ++k, at += width)
                if (!finite({&row[at], &row[at] + width})) std::fprintf(stderr, "not finite: %s\n", name);
            ++counts.endless, whole = false;
        }
        if (k == 2) Calls::save(twin, state.data());
    }
    Calls::restore(twin, state.data(), state.size());
    Calls::advance(twin, 1);
    Calls::free(twin);
}

/// Run a twin under a command, of which sensors break and a fin jams at times; count it if there is one.
void run_twin(const ht_robot* robot, int sea, bool broken, const std::vector<double>& gait, Counts& counts) {
    const ht_start start{sea, 3, 0.1, 1, 0, {0, 0}, 5};
    char fault[400];
    ht_twin* const twin = ht_twin_create(robot, &start, fault, sizeof(fault));
    if (!twin) return;
    ++counts.twins;
    if (broken) ht_twin_break(twin, 3, 0, 2), ht_twin_jam(twin, 0, 3);
    run<TwinCalls>(twin, gait, counts);
}

/// Run a device: with its controller, which the pilot steers where there is one, or the plant alone.
void run_device(const Bytes& image, int sea, int plant, const std::vector<double>& gait, Counts& counts) {
    const ht_start start{sea, 3, 0.1, 1, 0, {0, 0}, 5};
    char fault[400];
    ht_device* const device = ht_device_create(image.data(), image.size(), &start, plant, fault, sizeof(fault));
    if (!device) return;
    ++counts.devices;
    const double pulses[16] = {1e-3, 2e-3, 1.5e-3, 0, NAN, 1}, current[2] = {0.1, -0.2};
    ht_device_drive(device, pulses);
    ht_device_steer(device, 1, 2, 1);
    ht_device_flow(device, current);
    run<DeviceCalls>(device, gait, counts);
}

/// Fly a mission that there is, or is not; count it if there was one.
void run_flight(const ht_robot* robot, int mission, std::uint32_t seed, const std::vector<double>& gait,
                Counts& counts) {
    char fault[400] = "";
    ht_twin* const twin = ht_twin_fly(robot, mission, seed, fault, sizeof(fault));
    if (!twin) return;
    ++counts.flights;
    run<TwinCalls>(twin, gait, counts);
}

inline constexpr int parts = 9;

/// Read an image, and run what it allows.
void try_image(const Bytes& image, long turn, Counts& counts) {
    char fault[400] = "";
    ht_robot* const robot = ht_robot_read(image.data(), image.size(), fault, sizeof(fault));
    if (!robot) counts.silent += !fault[0];
    if (!robot) return;
    ++counts.read;
    const std::vector<double> gait = gait_of(robot);
    // a part for each image, all of the first
    for (long k = turn; k < (turn == 0 ? parts : turn + 1); ++k) {
        const int part = int(k % parts), sea = part % 2;
        if (part < 2) counts.endless += !swim(robot, int(k / parts % ht_robot_models(robot)), gait);
        if (part == 2 || part == 3) run_twin(robot, sea, k / parts % 2, gait, counts);
        if (part == 4 || part == 5) run_device(image, sea, 0, gait, counts);
        if (part == 6 || part == 7) run_device(image, sea, 1, gait, counts);
        if (part == 8) run_flight(robot, int(k % (ht_robot_missions(robot) + 1)), std::uint32_t(k % 3), gait, counts);
    }
    ht_robot_free(robot);
}

}  // namespace

int main(int argc, char** argv) {
    const Bytes good = argc < 3 ? Bytes() : file(argv[1]);
    if (good.size() < sizeof(ImageHeader)) {
        std::fputs("usage: fuzz_image IMAGE COUNT [SEED] [numbers]\n", stderr);
        return 2;
    }
    Chance chance{std::mt19937_64(argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 0)};
    const bool only_numbers = argc > 4;
    const long count = std::atol(argv[2]);
    Counts counts{};
    for (long k = 0; k < count; ++k) {
        Bytes image = good;
        if (0 < k) damage(image, chance, only_numbers);
        try_image(image, k, counts);
        if (counts.read == 0) return std::fputs("the image is refused as it is\n", stderr), 2;
    }
    std::printf("%ld images: %ld read, %ld twins, %ld devices and %ld flights run, %ld refused without a sentence, ",
                count, counts.read, counts.twins, counts.devices, counts.flights, counts.silent);
    std::printf("%ld neither finite nor ended\n", counts.endless);
    return counts.silent || counts.endless ? 1 : 0;
}
