/// Damage a robot image many times, each with a good checksum; read it, and where it is accepted, swim a gait, run
/// twins in the plane and at sea and fly a mission. Prints how many were read: fuzz_image IMAGE COUNT [SEED].
#include <cstdio>
#include <cstdlib>
#include <random>

#include "hypertuna.h"
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
    double number() {
        constexpr double odd[] = {0, -0.0, 1, -1, 0.5, 1e-300, 1e300, -1e300, 1e9, HUGE_VAL, -HUGE_VAL, NAN};
        return odd[below(std::size(odd))];
    }
};

/// Change bytes anywhere behind the header's checksum, numbers to odd ones, sizes in the header and of columns; at
/// times cut the end off.
void damage(Bytes& image, Chance& chance) {
    constexpr std::size_t body = offsetof(ImageHeader, columns);
    ImageHeader header;
    std::memcpy(&header, image.data(), sizeof(header));
    const std::size_t entries = sizeof(header), numbers = image.size() - 8 * std::size_t(header.numbers);
    for (std::size_t k = 1 + chance.below(3); k > 0; --k) {
        const std::size_t kind = chance.below(10);
        if (kind < 6) {
            const double odd = chance.number();
            std::memcpy(&image[numbers + 8 * chance.below(header.numbers)], &odd, sizeof(odd));
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
    if (chance.below(50) == 0) image.resize(sizeof(header) + chance.below(image.size() - sizeof(header)));
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

void swim(const ht_robot* robot, int model, const std::vector<double>& gait) {
    int count = 0;
    while (ht_quantity(count)) ++count;
    std::vector<double> quantities(count);
    ht_swim(robot, model, gait.data(), 1, 0, quantities.data());
}

/// Run a twin for 50 ticks, on a mission or under a command, and on from a state of its own.
void run(ht_twin* twin, const std::vector<double>& gait) {
    int numbers = 0;
    for (int k = 0, width = 0; ht_twin_column(twin, k, &width); ++k) numbers += width;
    std::vector<double> row(numbers);
    Bytes state(ht_twin_state_size(twin));
    const double fins[2] = {0.1, -0.1};
    ht_twin_command(twin, gait.data(), fins, 1);
    ht_twin_break(twin, 3, 0, 2);
    ht_twin_jam(twin, 0, 3);
    for (int k = 0; k < 5; ++k) {
        ht_twin_advance(twin, 10);
        ht_twin_read(twin, row.data());
        if (k == 2) ht_twin_save(twin, state.data());
    }
    ht_twin_restore(twin, state.data(), state.size());
    ht_twin_advance(twin, 1);
    ht_twin_free(twin);
}

/// Run a twin under a command; whether there is one.
bool run_twin(const ht_robot* robot, int sea, const std::vector<double>& gait) {
    const ht_start start{sea, 3, 0.1, 1, 0, {0, 0}, 5};
    char fault[400];
    ht_twin* const twin = ht_twin_create(robot, &start, fault, sizeof(fault));
    if (twin) run(twin, gait);
    return twin;
}

/// Fly a mission that there is, or is not; whether there was one.
bool run_flight(const ht_robot* robot, int mission, std::uint32_t seed, const std::vector<double>& gait) {
    char fault[400] = "";
    ht_twin* const twin = ht_twin_fly(robot, mission, seed, fault, sizeof(fault));
    if (twin) run(twin, gait);
    return twin;
}

}  // namespace

int main(int argc, char** argv) {
    const Bytes good = argc < 3 ? Bytes() : file(argv[1]);
    if (good.size() < sizeof(ImageHeader)) {
        std::fputs("usage: fuzz_image IMAGE COUNT [SEED]\n", stderr);
        return 2;
    }
    Chance chance{std::mt19937_64(argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 0)};
    const long count = std::atol(argv[2]);
    long read = 0, twins = 0, flights = 0, silent = 0;
    for (long k = 0; k < count; ++k) {
        Bytes image = good;
        damage(image, chance);
        char fault[400] = "";
        ht_robot* const robot = ht_robot_read(image.data(), image.size(), fault, sizeof(fault));
        if (!robot) silent += !fault[0];
        if (!robot) continue;
        ++read;
        const std::vector<double> gait = gait_of(robot);
        swim(robot, int(k % ht_robot_models(robot)), gait);
        for (int sea = 0; sea < 2; ++sea) twins += run_twin(robot, sea, gait);
        const int missions = ht_robot_missions(robot);
        flights += run_flight(robot, int(k % (missions + 1)), std::uint32_t(k % 3), gait);
        ht_robot_free(robot);
    }
    std::printf("%ld images: %ld read, %ld twins and %ld flights run, %ld refused without a sentence\n", count, read,
                twins, flights, silent);
    return silent ? 1 : 0;
}
