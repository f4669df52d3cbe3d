/// The store: whatever byte the power goes at, what is read back is the old set or the new one.
#include "../../core/tests/check.hpp"
#include "memory_board.hpp"

using namespace hypertuna::firmware;

static MemoryBoard board;
static Store store;

/// A set that cannot be mistaken for another: every byte depends on which.
static void fill(Store& to, int which) {
    for (int k = 0; k < to.size; ++k) to.kept[k] = std::uint8_t(31 * k + 97 * which + 1);
}

static bool holds(const Store& in, int which) {
    static Store wanted;
    wanted.size = in.size;
    fill(wanted, which);
    return std::memcmp(in.kept, wanted.kept, std::size_t(in.size)) == 0;
}

static void write_all() {
    for (int k = 0; k < 4 * most_kept && !settled(store); ++k) write_some(store, board);
}

/// A store as it boots from what the memory holds.
static bool reboot(int size, std::uint32_t layout = 7) {
    store = {};
    store.size = size, store.layout = layout;
    return open(store, board);
}

static void checksums_are_those_of_the_standard() {
    CHECK(crc32(reinterpret_cast<const std::uint8_t*>("123456789"), 9) == 0xcbf43926u);  // the check value of CRC-32
}

static void nothing_is_read_from_an_empty_memory() {
    for (int fill : {0, 0xff}) {
        board = {}, board.power = -1;
        std::memset(board.kept, fill, sizeof(board.kept));
        CHECK(!reboot(100));
    }
}

static void what_is_kept_is_read_back() {
    board = {}, board.power = -1;
    CHECK(!reboot(100));
    for (int which = 0; which < 5; ++which) {
        fill(store, which);
        keep(store);
        CHECK(!settled(store));
        write_all();
        CHECK(settled(store));
        CHECK(reboot(100) && holds(store, which));
    }
    CHECK(!reboot(100, 8));  // of another layout
}

/// Cut the power at every byte of a write, with every kind of torn byte, from both slots.
static void power_cuts() {
    const int size = 300, bytes = 4 + size + slot_head;
    int old_sets = 0, new_sets = 0;
    for (int before = 1; before <= 2; ++before)
        for (int cut = 0; cut <= bytes; ++cut)
            for (int torn : {-1, 0x00, 0xff, 0x5a}) {
                board = {}, board.power = -1;
                reboot(size);
                for (int which = 0; which < before; ++which) fill(store, which), keep(store), write_all();
                board.power = cut, board.torn = torn;
                fill(store, before), keep(store), write_all();
                board.power = -1;
                CHECK(reboot(size));
                const bool is_old = holds(store, before - 1), is_new = holds(store, before);
                CHECK(is_old != is_new);
                old_sets += is_old, new_sets += is_new;
                // The next write works as if nothing had been.
                fill(store, 9), keep(store), write_all();
                CHECK(reboot(size) && holds(store, 9));
            }
    CHECK(old_sets + new_sets == 2 * 4 * (bytes + 1));
    CHECK(new_sets >= 2 * 4 && old_sets >= 2 * 4 * (bytes - 1));  // only a whole write leaves the new set
    std::printf("power cuts: %d, old set %d, new set %d, mixtures 0\n", old_sets + new_sets, old_sets, new_sets);
}

/// What changes while it is written is written anew, as a whole.
static void a_change_during_the_write() {
    for (int at = 0; at < 60; ++at) {
        board = {}, board.power = -1;
        reboot(300);
        fill(store, 0), keep(store), write_all();
        fill(store, 1), keep(store);
        for (int k = 0; k < at; ++k) write_some(store, board);
        fill(store, 2), keep(store), write_all();
        CHECK(settled(store) && reboot(300) && holds(store, 2));
    }
}

/// The counter of turns wraps.
static void turns_wrap() {
    board = {}, board.power = -1;
    reboot(40);
    store.turn = 0xfffffffdu;
    for (int which = 0; which < 6; ++which) {
        fill(store, which), keep(store), write_all();
        CHECK(reboot(40) && holds(store, which));
    }
}

int main() {
    checksums_are_those_of_the_standard();
    nothing_is_read_from_an_empty_memory();
    what_is_kept_is_read_back();
    power_cuts();
    a_change_during_the_write();
    turns_wrap();
    return failures();
}
