/// The store on flash memory: at any operation where the power fails, the old set or the new one is read back.
#include "../../../core/tests/check.hpp"
#include "flash/eeprom_log.hpp"
#include "memory_board.hpp"

using namespace hypertuna::firmware;

static MemoryBoard board;
static Store store;
static std::uint8_t stored[sizeof(StoredMission)];

/// Fill a set that differs from every other in every byte, which depends on `which`.
static std::uint8_t byte_of(int which, int k) { return std::uint8_t(31 * k + 97 * which + (which >> 8) + 1); }
static void fill(int which) {
    for (int k = 0; k < store.size; ++k) stored[k] = byte_of(which, k);
}

static bool holds(int which) {
    for (int k = 0; k < store.size; ++k)
        if (stored[k] != byte_of(which, k)) return false;
    return true;
}

static void write_all() {
    for (int k = 0; k < 100 && !settled(store); ++k) write_some(store, stored, board);
    CHECK(settled(store));
}

/// A store as it boots from what the memory holds.
static bool reboot(int size, std::uint32_t layout = 7) {
    board.flash.boot();
    store = store_at(2, size, layout);
    std::memset(stored, 0, sizeof stored);
    return open(store, stored, board);
}

static void begin(std::uint64_t seed = 1) { board = {}, board.flash.begin(), board.flash.dice.state = seed; }

static void checksums_are_those_of_the_standard() {
    CHECK(crc32(reinterpret_cast<const std::uint8_t*>("123456789"), 9) == 0xcbf43926u);  // the check value of CRC-32
}

static void nothing_is_read_from_an_empty_memory() {
    for (int fill : {0, 0xff}) {
        begin();
        std::memset(board.flash.bytes, fill, sizeof(board.flash.bytes));
        CHECK(!reboot(100));
    }
}

static void what_is_kept_is_read_back() {
    begin();
    CHECK(!reboot(100));
    for (int which = 0; which < 50; ++which) {
        fill(which);
        begin_write(store);
        CHECK(!settled(store));
        write_all();
        if (which % 20 == 19) CHECK(reboot(100) && holds(which));
    }
    CHECK(reboot(100) && holds(49) && store.turn == 50);
    CHECK(board.flash.erasures == 13);  // four records fit into a sector; another sector at each boot
    CHECK(!reboot(100, 8));             // a record of another layout
    CHECK(board.flash.outside == 0);
}

/// The emulated EEPROM of the board, which the store does not use: two copies far apart, like two slots of a store,
/// share their sectors, and a cut of one erasure takes both.
static void the_emulated_eeprom_loses_both_copies() {
    static EepromLog eeprom;
    const int size = 336, copies[2] = {0, 352};
    int lost = 0;
    for (int cut = 0; cut < 40; ++cut) {
        eeprom.flash.begin(), eeprom.flash.dice.state = std::uint64_t(cut) + 1, eeprom.boot();
        const auto write = [&](int copy, int which) {
            for (int k = 0; k < size; ++k) eeprom.write(copies[copy] + k, byte_of(which, k));
        };
        int which = 0;
        for (; eeprom.flash.erasures == 0; ++which) write(which % 2, which);  // until a log is full
        for (int k = 0; k < 4096 && eeprom.used[0] < EepromLog::pairs; ++k) eeprom.write(0, std::uint8_t(k));
        eeprom.flash.power = 0;
        eeprom.write(0, std::uint8_t(eeprom.read(0) + 1));
        eeprom.boot();
        bool whole = false;
        for (int copy : copies)
            for (int of = 0; of < which; ++of) {
                bool all = true;
                for (int k = 4; k < size && all; ++k)
                    all = eeprom.read(copy + k) == byte_of(of, k);  // except the write that was cut off
                whole = whole || all;
            }
        lost += !whole;
    }
    std::printf("emulated EEPROM: of 40 cuts in an erasure, %d lose both copies\n", lost);
    CHECK(lost > 20);
}

/// Cut the power at any operation of a write, often again at one of the next boot or write, in chains of cuts.
static void power_cuts(int size, int cuts, std::uint64_t seed) {
    int sets[3] = {}, at_boot = 0, chained = 0;
    Dice dice{seed};
    const int operations = 4 + (size + piece - 1) / piece;
    int before = -1, next = 0;  // the stored set, none at first; the set to write next
    bool fresh = true;          // the board is new
    for (int cut = 0; cut < cuts; ++cut) {
        if (fresh) begin(dice.roll()), before = -1;
        if (fresh) CHECK(!reboot(size));
        for (int writes = dice.below(4) * dice.below(2); writes > 0; --writes)
            fill(next), begin_write(store), write_all(), before = next++;
        board.flash.power = dice.below(2) == 0 ? operations - 1 - dice.below(3) : dice.below(operations);  // flags
        int written = next++;
        fill(written), begin_write(store), write_all();
        board.flash.boot();
        while (dice.happens(0.3)) {  // again, before the stored set was read
            board.flash.power = 0, ++at_boot;
            store = store_at(2, size, 7);
            open(store, stored, board);
            board.flash.boot();
        }
        const bool valid = reboot(size), is_old = valid ? before >= 0 && holds(before) : before < 0,
                   is_new = valid && holds(written);
        CHECK(is_old != is_new);
        ++sets[is_new];
        if (is_new) before = written;
        for (int boots = 0; boots < 3; ++boots)
            CHECK(reboot(size) == valid && (!valid || holds(before)));  // so it stays
        fresh = dice.below(40) == 0, chained += !fresh;
    }
    CHECK(sets[0] > cuts / 3 && sets[1] > 0 && sets[0] + sets[1] == cuts && board.flash.outside == 0);
    std::printf("%4d bytes: %d power cuts, %d right after another, %d at the boot besides: old set %d, new set %d\n",
                size, cuts, chained, at_boot, sets[0], sets[1]);
}

/// A record that cannot be read back is reported, and an intact record stays intact.
static void a_worn_byte() {
    begin();
    reboot(300);
    fill(0), begin_write(store), write_all();
    CHECK(!store.failed && store.kept == 0);
    CHECK(reboot(300));
    board.flash.worn = address(store, 1, 0) + piece + 7;  // of the record that is written next
    fill(2), begin_write(store), write_all();
    CHECK(store.failed && settled(store));
    fill(3), begin_write(store), write_all();  // again the same one
    CHECK(store.failed);
    CHECK(reboot(300) && holds(0));
    board.flash.worn = -1;
    fill(4), begin_write(store), write_all();
    CHECK(!store.failed && reboot(300) && holds(4));
}

/// A value that changes while it is written is written again as a whole.
static void a_change_during_the_write() {
    for (int at = 0; at < 10; ++at)
        for (int writes = 0; writes < 20; ++writes) {
            begin();
            reboot(300);
            fill(0), begin_write(store), write_all();
            for (int k = 0; k < writes; ++k) begin_write(store), write_all();
            fill(1), begin_write(store);
            for (int k = 0; k < at; ++k) write_some(store, stored, board);
            fill(2), begin_write(store);
            for (; !settled(store); write_some(store, stored, board)) CHECK(!store.failed);
            CHECK(reboot(300) && holds(2));
        }
}

/// The counter of the turns wraps around.
static void turns_wrap() {
    begin();
    reboot(40);
    store.turn = 0xfffffffdu;
    for (int which = 0; which < 6; ++which) {
        fill(which), begin_write(store), write_all();
        CHECK(reboot(40) && holds(which));
    }
}

/// Witnesses are complete, or completed at the next boot: never spoiled for good.
static void witnesses_last() {
    for (int cut = 0; cut < 300; ++cut) {
        begin(std::uint64_t(cut) + 1);
        CHECK(count_witnesses(board, 8) == 0);
        board.flash.power = cut % 9;
        bear_witness(board, 8);
        board.flash.boot();
        CHECK(bear_witness(board, 8) && count_witnesses(board, 8) == witnesses);
    }
}

int main() {
    checksums_are_those_of_the_standard();
    nothing_is_read_from_an_empty_memory();
    what_is_kept_is_read_back();
    the_emulated_eeprom_loses_both_copies();
    power_cuts(300, 4000, 1);
    power_cuts(int(sizeof(StoredMission)), 3000, 2);
    power_cuts(8, 4000, 3);
    a_worn_byte();
    a_change_during_the_write();
    turns_wrap();
    witnesses_last();
    return failures();
}
