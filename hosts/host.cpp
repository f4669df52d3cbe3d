/// The C interface over the core: see hypertuna.h.
#include "hypertuna.h"
#include "image.hpp"
#include "swim.hpp"
#include "twin.hpp"

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
// What the library calls where it gives up, as without memory. Its own ones print first, with 16 kB of code.
extern "C" [[noreturn]] void __abort_message(const char*, ...) { __builtin_trap(); }
namespace std::inline __1 {
[[noreturn]] void __libcpp_verbose_abort(const char*, ...) noexcept { __builtin_trap(); }
}  // namespace std::inline __1
#endif

namespace {

/// Write a sentence to a host that has room for it.
void tell(const std::string& sentence, char* fault, std::size_t room) {
    if (!fault || room == 0) return;
    const std::size_t size = std::min(sentence.size(), room - 1);
    std::memcpy(fault, sentence.data(), size);
    fault[size] = '\0';
}

/// Take what a loader returns, or keep the first of its faults.
template <class T>
std::optional<T> take(Loaded<T>&& loaded, std::string& fault) {
    if (fault.empty()) fault = loaded.fault;
    return std::move(loaded.object);
}

std::optional<HostModel> read_model(const NamedColumns& columns, std::string& fault) {
    ColumnReader in(columns);
    const int law = in.whole("law", 0, WaterLaws::count - 1);
    const double mass = in.number("robot_mass");
    std::string name;
    int place = 0;
    WaterLaws::each<double>([&](auto listed) {
        if (place++ == law) name = decltype(listed)::type::name;
    });
    if (fault.empty()) fault = in.fault();
    std::optional<Model> model = take(load_model(name, columns), fault);
    if (!model) return std::nullopt;
    return HostModel{std::move(*model), mass};
}

/// A mission and its world.
std::optional<MissionParts> read_mission(const NamedColumns& columns, std::string& fault) {
    ColumnReader in(columns);
    std::optional<MissionData> data = take(load_mission(columns), fault);
    std::optional<World> world = take(load_world(columns), fault);
    if (world && !world->sea) in.refuse("sea.density: is missing");
    const double hash = in.number("scatter.hash");
    if (!(0 <= hash && hash < 4294967296.0)) in.refuse("scatter.hash: must be a whole number of 32 bits");
    Scatter scatter{in.number("scatter.current"), in.whole("scatter.gaps", 0, 1000), in.number("scatter.gap"),
                    in.number("scatter.span"), 0};
    if (in.fault().empty()) scatter.hash = std::uint32_t(hash);
    const int ticks = in.whole("ticks", 1, 1 << 30);
    const std::vector<double> pose = in.numbers("pose", 7);
    const double charge = in.number("charge");
    if (fault.empty()) fault = in.fault();
    if (!data || !world || !fault.empty()) return std::nullopt;
    return MissionParts{std::move(*data),
                        std::move(*world),
                        scatter,
                        std::uint64_t(ticks),
                        {{pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5], pose[6]}, {0, 0}},
                        charge};
}

/// The pilot of a robot that has one, and its missions.
void read_missions(const Image& image, TwinParts& parts, std::string& fault) {
    const NamedColumns pilot = image.part("pilot.");
    if (pilot.empty()) return;
    parts.pilot = take(load_pilot(parts.controller, pilot), fault);
    if (fault.empty() && !parts.plant.space) fault = "image: a pilot needs a robot that is described in space";
    for (int k = 0; fault.empty(); ++k) {
        const NamedColumns columns = image.part("missions." + std::to_string(k) + ".");
        if (columns.empty()) return;
        if (std::optional<MissionParts> mission = read_mission(columns, fault))
            parts.missions.push_back(std::move(*mission));
    }
}

std::unique_ptr<TwinParts> read_twin(const Image& image, const Model& model, std::string& fault) {
    std::optional<PlantData> plant = take(load_plant(model, image.part("plant.")), fault);
    const std::optional<Controller<double>> controller = take(load_controller(image.part("controller.")), fault);
    const std::optional<Sensors<double>> sensors = take(load_sensors(image.part("sensors."), 0), fault);
    const NamedColumns run = image.part("run.");
    ColumnReader in(run);
    const int steps = in.whole("steps", 1, 10000);
    if (fault.empty()) fault = in.fault();
    if (!plant || !controller || !sensors || !fault.empty()) return nullptr;
    if (controller->joints != plant->joints || sensors->joints != plant->joints) {
        fault = "image: plant, controller and sensors must have as many joints as each other";
        return nullptr;
    }
    const int coordinates = plant->coordinates;
    pad(*plant);
    auto parts = std::make_unique<TwinParts>(
        TwinParts{std::move(*plant), *controller, *sensors, steps, coordinates, std::nullopt, {}});
    read_missions(image, *parts, fault);
    return parts;
}

}  // namespace

extern "C" {

ht_robot* ht_robot_read(const unsigned char* bytes, size_t size, char* fault, size_t room) {
    std::string wrong;
    std::optional<Image> image = take(read_image(bytes, size), wrong);
    auto robot = std::make_unique<ht_robot>();
    if (image) robot->image = std::move(*image);
    for (int k = 0; wrong.empty(); ++k) {
        const NamedColumns columns = robot->image.part("models." + std::to_string(k) + ".");
        if (columns.empty()) break;
        if (std::optional<HostModel> model = read_model(columns, wrong)) robot->models.push_back(std::move(*model));
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

const char* ht_quantity(int index) { return 0 <= index && index < quantity_count ? quantities[index].name : nullptr; }
const char* ht_derivative(int index) {
    return 0 <= index && index < derivative_count ? derivatives[index].name : nullptr;
}

void ht_swim(const ht_robot* robot, int model, const double* gaits, int count, int follow, double* out) {
    swim(robot->models[model], gaits, count, follow != 0, out);
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
    if (!robot->twin) return refused("twin: the robot has no controller; describe one and write the image again");
    const TwinParts& parts = *robot->twin;
    World world{};
    Run run{0, 1, parts.controller.tick, parts.steps, {{-start->speed, 0, 0}, {0, 0, 0}}, {}, 0};
    if (start->sea) {
        ColumnReader in(robot->sea);
        Sea<double> sea = read_sea<double>(in.row("sea", sea_columns).data());
        if (!in.fault().empty() || !parts.plant.space)
            return refused("twin: the robot is not described in space; add tables spatial and fins");
        std::copy(start->current, start->current + 2, sea.current);
        sea.bottom = start->bottom;
        world.sea = sea;
        // The body's first axis points to the tail.
        run.pose = {{0, 0, -start->depth}, {std::sin(start->heading / 2), 0, 0, -std::cos(start->heading / 2)}, {0, 0}};
    }
    tell("", fault, room);
    const auto begin = [&](auto twins) { return twins.start(parts, start->seed, run, world); };
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
    const auto begin = [&](auto twins) { return twins.fly(parts, parts.missions[mission], seed); };
    return new ht_twin{robot, with_tail(parts.plant, begin)};
}
void ht_twin_free(ht_twin* twin) { delete twin; }

void ht_twin_command(ht_twin* twin, const double* gait, const double fins[2], int armed) {
    Command<double>& to = twin->live->command;
    const int joints = twin->robot->twin->controller.joints;
    to.frequency = gait[0];
    for (int j = 0; j < joints; ++j) {
        to.amplitude[j] = gait[1 + j];
        to.phase[j] = std::remainder(gait[1 + joints + j] - gait[1 + joints], 2 * pi);  // behind the first joint's
        to.bias[j] = gait[1 + 2 * joints + j];
    }
    std::copy(fins, fins + 2, to.fin);
    to.fresh = true;
    to.armed = armed != 0;
}

void ht_twin_break(ht_twin* twin, int kind, int first, int last) {
    std::vector<Fault<double>>& faults = twin->live->instruments.faults;
    if (kind < 0 || int(FaultKind::nan) < kind) return;
    faults.insert(faults.begin(), {FaultKind(kind), first, last, twin->live->time(), HUGE_VAL});
}

void ht_twin_jam(ht_twin* twin, int fin, int kind) {
    constexpr double part[] = {0, std::numeric_limits<double>::quiet_NaN(), 0, 1, -1};  // of the largest angle
    if (fin < 0 || 1 < fin || kind < 0 || int(std::size(part)) <= kind) return;
    twin->live->jam(fin, part[kind] * twin->robot->twin->controller.fin_max, kind != 0);
}

int ht_twin_advance(ht_twin* twin, int ticks) { return twin->live->advance(ticks); }

const char* ht_twin_column(const ht_twin* twin, int index, int* width) {
    const std::vector<RecordColumn>& columns = twin->live->row.columns;
    if (index < 0 || int(columns.size()) <= index) return nullptr;
    *width = int(columns[index].width);
    return columns[index].name.c_str();
}
void ht_twin_read(const ht_twin* twin, double* row) {
    for (const RecordColumn& column : twin->live->row.columns)
        row = std::copy(column.values.begin(), column.values.end(), row);
}

size_t ht_twin_state_size(const ht_twin* twin) { return twin->live->state_size(); }
void ht_twin_save(const ht_twin* twin, unsigned char* state) { twin->live->save(state); }
int ht_twin_restore(ht_twin* twin, const unsigned char* state, size_t size) {
    if (size != twin->live->state_size()) return 0;
    twin->live->restore(state);
    return 1;
}

}  // extern "C"
