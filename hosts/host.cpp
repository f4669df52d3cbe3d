/// The C interface over the core: see hypertuna.h.
#include "hypertuna.h"
#include "robot.hpp"

using namespace hypertuna;

struct ht_robot {
    std::vector<HostModel> models;
    std::unique_ptr<TwinParts> twin;
    NamedColumns sea;
    Image image;
};

struct ht_twin {
    const ht_robot* robot;
    std::unique_ptr<LiveTwin> live;
};

#ifdef __wasm__
// The library calls these where it gives up, for example without memory. Its own versions print first, which takes 16
// kB of code.
extern "C" [[noreturn]] void __abort_message(const char*, ...) { __builtin_trap(); }
namespace std::inline __1 {
[[noreturn]] void __libcpp_verbose_abort(const char*, ...) noexcept { __builtin_trap(); }
}  // namespace std::inline __1
#endif

extern "C" {

ht_robot* ht_robot_read(const unsigned char* bytes, size_t size, char* fault, size_t room) {
    std::string wrong;
    std::optional<Image> image = take(read_image(bytes, size), wrong);
    auto robot = std::make_unique<ht_robot>();
    if (image) robot->image = std::move(*image);
    for (int k = 0; wrong.empty(); ++k) {
        const NamedColumns columns = robot->image.part("models." + std::to_string(k) + ".");
        if (columns.empty()) break;
        if (std::optional<HostModel> model = read_model(columns, wrong)) {
            read_hinges(columns, *model, wrong);
            robot->models.push_back(std::move(*model));
        }
    }
    if (wrong.empty() && robot->models.empty()) wrong = "image: has no model; write it again";
    for (const HostModel& host : robot->models)
        if (host.model.groups != robot->models[0].model.groups || host.model.links != robot->models[0].model.links)
            wrong = "image: all models must have the same links and joints";
    if (wrong.empty() && !robot->image.part("plant.").empty())
        robot->twin = read_twin(robot->image, robot->models[0].model, wrong);
    robot->sea = robot->image.part("world.");
    tell(wrong, fault, room);
    return wrong.empty() ? robot.release() : nullptr;
}

void ht_robot_free(ht_robot* robot) { delete robot; }

const char* ht_robot_text(const ht_robot* robot, size_t* size) {
    *size = robot->image.text.size();
    return robot->image.text.data();
}
int ht_robot_groups(const ht_robot* robot) { return robot->models[0].model.groups; }
int ht_robot_links(const ht_robot* robot) { return robot->models[0].model.links; }
int ht_robot_models(const ht_robot* robot) { return int(robot->models.size()); }
int ht_robot_missions(const ht_robot* robot) { return robot->twin ? int(robot->twin->missions.size()) : 0; }

const char* ht_quantity(int index) { return quantity(index) ? quantity(index)->name : nullptr; }
const char* ht_quantity_label(int index) { return quantity(index) ? quantity(index)->label : nullptr; }
const char* ht_quantity_unit(int index) { return quantity(index) ? quantity(index)->unit : nullptr; }
int ht_quantity_shown(int index) { return quantity(index) ? int(quantity(index)->shown) : 0; }
int ht_quantity_better(int index) { return quantity(index) ? int(quantity(index)->better) : 0; }
const char* ht_derivative(int index) {
    for (int k = 0; quantity(k); ++k)
        if (quantity(k)->differentiable && index-- == 0) return quantity(k)->name;
    return nullptr;
}

void ht_swim(const ht_robot* robot, int model, const double* gaits, int count, int follow, double* out) {
    swim_rows(robot->models[model], gaits, count, follow != 0, out);
}
void ht_verdict(const double* gait, const double* quantities, char* text, size_t room) {
    const auto number = [&](std::string_view name) { return quantities[place_of(name, ht_quantity)]; };
    tell(verdict(BeatStatus(int(number("status"))), number("beats"), number("distance_to_settled"),
                 number("spectral_radius"), number("turn_rate") / gait[0]),
         text, room);
}
void ht_gradient(const ht_robot* robot, int model, const double* gait, double* out) {
    gait_gradient(robot->models[model], gait, out);
}
void ht_path(const ht_robot* robot, int model, const double* gait, int steps, double* rows) {
    path(robot->models[model], gait, steps, rows);
}

ht_twin* ht_twin_create(const ht_robot* robot, const ht_start* start, char* fault, size_t room) {
    const auto refused = [&](const std::string& sentence) {
        tell(sentence, fault, room);
        return nullptr;
    };
    if (!robot->twin) return refused(no_controller);
    const TwinParts& parts = *robot->twin;
    World world{};
    Run run{};
    const std::string wrong = read_start(*start, parts, robot->sea, run, world);
    if (!wrong.empty()) return refused(wrong);
    tell("", fault, room);
    const auto begin = [&](auto tail) { return Twins<tail.value>::start(parts, start->seed, run, world); };
    return new ht_twin{robot, with_tail(parts.plant, begin)};
}
ht_twin* ht_twin_fly(const ht_robot* robot, int mission, uint32_t seed, char* fault, size_t room) {
    const int count = ht_robot_missions(robot);
    std::string wrong;
    if (!robot->twin || !robot->twin->pilot)
        wrong = "flight: the robot has no pilot; describe it at sea, with table guidance, and write the image again";
    else if (mission < 0 || count <= mission)
        wrong = "flight: there is no mission " + std::to_string(mission) + "; the image has " + std::to_string(count) +
                ", from 0 on";
    tell(wrong, fault, room);
    if (!wrong.empty()) return nullptr;
    const TwinParts& parts = *robot->twin;
    const auto begin = [&](auto tail) { return Twins<tail.value>::fly(parts, parts.missions[mission], seed); };
    return new ht_twin{robot, with_tail(parts.plant, begin)};
}
void ht_twin_free(ht_twin* twin) { delete twin; }

void ht_twin_command(ht_twin* twin, const double* gait, const double fins[2], int armed) {
    set_command(twin->live->command, twin->robot->twin->controller.joints, gait, fins, armed != 0);
}

void ht_twin_break(ht_twin* twin, int kind, int first, int last) {
    std::vector<Fault<double>>& faults = twin->live->instruments.faults;
    if (kind < 0 || int(FaultKind::count) <= kind) return;
    faults.insert(faults.begin(), {FaultKind(kind), first, last, twin->live->time(), HUGE_VAL});
}

void ht_twin_jam(ht_twin* twin, int fin, int kind) {
    constexpr double part[] = {0, std::numeric_limits<double>::quiet_NaN(), 0, 1, -1};  // of the largest angle
    if (fin < 0 || 1 < fin || kind < 0 || int(std::size(part)) <= kind) return;
    twin->live->jam(fin, part[kind] * twin->robot->twin->controller.fin_max, kind != 0);
}

int ht_twin_advance(ht_twin* twin, int ticks) { return twin->live->advance(ticks); }

const char* ht_twin_column(const ht_twin* twin, int index, int* width) { return column(twin->live->row, index, width); }
void ht_twin_read(const ht_twin* twin, double* row) { read_row(twin->live->row, row); }

size_t ht_twin_state_size(const ht_twin* twin) { return twin->live->state_size(); }
void ht_twin_save(const ht_twin* twin, unsigned char* state) { twin->live->save(state); }
int ht_twin_restore(ht_twin* twin, const unsigned char* state, size_t size) {
    if (size != twin->live->state_size()) return 0;
    twin->live->restore(state);
    return 1;
}

}  // extern "C"
