/// The store: whatever byte the power goes at, what is read back is the old set or the new one.
#include "../../../core/tests/check.hpp"
#include "memory_board.hpp"

using namespace hypertuna::firmware;

static MemoryBoard board;
static Store store;
static std::uint8_t stored[sizeof(StoredMission)];

/// A set that cannot be mistaken for another: every byte depends on which.
static std::uint8_t byte_of(int which, int k) { return std::uint8_t(31 * k + 97 * which + 1); }
static void fill(int which) {
    for (int k = 0; k < store.size; ++k) stored[k] = byte_of(which, k);
}

static bool holds(int which) {
    for (int k = 0; k < store.size; ++k)
        if (stored[k] != byte_of(which, k)) return false;
    return true;
}

static void write_all() {
    for (int k = 0; k < 4000 && !settled(store); ++k) write_some(store, stored, board);
}

/// A store as it boots from what the memory holds.
static int base = 0;
static bool reboot(int size, std::uint32_t layout = 7) {
    store = {base, size, layout, 0, -1, false, false, {}};
    std::memset(stored, 0, sizeof stored);
    return open(store, stored, board);
}

static void checksums_are_those_of_the_standard() {
    CHECK(crc32(reinterpret_cast<const std::uint8_t*>("123456789"), 9) == 0xcbf43926u);  // the check value of CRC-32
}

static void nothing_is_read_from_an_empty_memory() {
    for (int fill : {0, 0xff}) {
        board = {}, board.power = -1;
        std::memset(board.memory, fill, sizeof(board.memory));
        CHECK(!reboot(100));
    }
}

static void what_is_kept_is_read_back() {
    board = {}, board.power = -1;
    CHECK(!reboot(100));
    for (int which = 0; which < 5; ++which) {
        fill(which);
        begin_write(store);
        CHECK(!settled(store));
        write_all();
        CHECK(settled(store));
        CHECK(reboot(100) && holds(which));
    }
    CHECK(!reboot(100, 8));  // of another layout
}

/// Cut the power at every byte of a write, with every kind of torn byte, from both slots.
static void power_cuts(int size, int from) {
    base = from;
    const int bytes = 4 + size + slot_head;
    int old_sets = 0, new_sets = 0;
    for (int before = 1; before <= 2; ++before)
        for (int cut = 0; cut <= bytes; ++cut)
            for (int torn : {-1, 0x00, 0xff, 0x5a}) {
                board = {}, board.power = -1;
                reboot(size);
                for (int which = 0; which < before; ++which) fill(which), begin_write(store), write_all();
                board.power = cut, board.torn = torn;
                fill(before), begin_write(store), write_all();
                board.power = -1;
                CHECK(reboot(size));
                const bool is_old = holds(before - 1), is_new = holds(before);
                CHECK(is_old != is_new);
                old_sets += is_old, new_sets += is_new;
                // The next write works as if nothing had been.
                fill(9), begin_write(store), write_all();
                CHECK(reboot(size) && holds(9));
            }
    CHECK(old_sets + new_sets == 2 * 4 * (bytes + 1));
    CHECK(new_sets >= 2 * 4 && old_sets >= 2 * 4 * (bytes - 1));  // only a whole write leaves the new set
    std::printf("%d bytes, power cuts: %d, old set %d, new set %d, mixtures 0\n", size, old_sets + new_sets, old_sets,
                new_sets);
    base = 0;
}

/// What cannot be read back is told, and the slot that is whole stays so.
static void a_worn_byte() {
    board = {}, board.power = -1;
    reboot(300);
    fill(0), begin_write(store), write_all();
    fill(1), begin_write(store), write_all();
    CHECK(!store.failed);
    board.worn = int(~store.turn & 1) * (slot_head + 300) + slot_head + 7;  // of the slot that is written next
    fill(2), begin_write(store), write_all();
    CHECK(store.failed && settled(store));
    fill(3), begin_write(store), write_all();  // again the same one
    CHECK(store.failed);
    board.worn = -1;
    CHECK(reboot(300) && holds(1));
    fill(4), begin_write(store), write_all();
    CHECK(!store.failed && reboot(300) && holds(4));
}

/// What changes while it is written is written again, as a whole.
static void a_change_during_the_write() {
    for (int at = 0; at < 60; ++at) {
        board = {}, board.power = -1;
        reboot(300);
        fill(0), begin_write(store), write_all();
        fill(1), begin_write(store);
        for (int k = 0; k < at; ++k) write_some(store, stored, board);
        fill(2), begin_write(store), write_all();
        CHECK(settled(store) && reboot(300) && holds(2));
    }
}

/// The counter of turns wraps.
static void turns_wrap() {
    board = {}, board.power = -1;
    reboot(40);
    store.turn = 0xfffffffdu;
    for (int which = 0; which < 6; ++which) {
        fill(which), begin_write(store), write_all();
        CHECK(reboot(40) && holds(which));
    }
}

int main() {
    checksums_are_those_of_the_standard();
    nothing_is_read_from_an_empty_memory();
    what_is_kept_is_read_back();
    power_cuts(300, 0);
    power_cuts(int(sizeof(StoredMission)), missions_at);
    power_cuts(8, stamps_at);
    a_worn_byte();
    a_change_during_the_write();
    turns_wrap();
    return failures();
}
