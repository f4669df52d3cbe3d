/// Parts of the C interfaces: reading a robot's image and the numbers from a host.
#pragma once

#include "hypertuna.h"
#include "image.hpp"
#include "swim.hpp"
#include "twin.hpp"

namespace hypertuna {

/// Write a sentence into a host's buffer of `room` bytes, cut to fit.
inline void tell(const std::string& sentence, char* fault, std::size_t room) {
    if (!fault || room == 0) return;
    const std::size_t size = std::min(sentence.size(), room - 1);
    std::memcpy(fault, sentence.data(), size);
    fault[size] = '\0';
}

inline constexpr char no_controller[] = "twin: the robot has no controller; describe one and write the image again";

/// Take the object that a loader returns, and keep the first fault.
template <class T>
inline std::optional<T> take(Loaded<T>&& loaded, std::string& fault) {
    if (fault.empty()) fault = loaded.fault;
    return std::move(loaded.object);
}

/// Read the hinges that yield in settled beats, where a model has them.
inline void read_hinges(const NamedColumns& columns, HostModel& host, std::string& fault) {
    ColumnReader in(columns);
    const NamedColumn* const found = in.find("spring.link");
    if (!found) return;
    const int count = int(found->rows * found->width);
    if (count < 1 || max_hinges < count) return void(fault = "image: spring.link: must have 1 to 3 numbers");
    for (int d = 0; d < count; ++d) {
        const double link = in.number("spring.link", d);
        const int first = d ? host.hinges[d - 1] + 1 : std::max(1, host.model.links - max_hung);
        if (!(first <= link && link < host.model.links))
            in.refuse("spring.link: must be links behind the head, head to tail");
        host.hinges.push_back(int(link));
        host.springs.push_back(
            read_row<Spring<double>, double>(spring_columns, in.row("spring", spring_columns, d).data()));
    }
    fault = in.fault();
    if (fault.empty()) host.rates = spring_rates(kernel_portable_yielding, host.model, host.hinges, host.springs);
}

inline std::optional<HostModel> read_model(const NamedColumns& columns, std::string& fault) {
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
    return HostModel{std::move(*model), mass, {}, {}, {}};
}

/// Read a mission and its world.
inline std::optional<MissionParts> read_mission(const NamedColumns& columns, std::string& fault) {
    ColumnReader in(columns);
    std::optional<MissionData> data = take(load_mission(columns), fault);
    std::optional<World> world = take(load_world(columns), fault);
    if (world && !world->sea) in.refuse("sea.density: is missing");
    const Scatter scatter{in.number("scatter.current"), in.whole("scatter.gaps", 0, 1000), in.number("scatter.gap"),
                          in.number("scatter.span"), std::uint32_t(in.number("scatter.hash"))};
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

/// Read the pilot of a robot that has one, and its missions.
inline void read_missions(const Image& image, TwinParts& parts, std::string& fault) {
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

inline std::unique_ptr<TwinParts> read_twin(const Image& image, const Model& model, std::string& fault) {
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
    pad(*plant, plant->own <= short_tail ? short_tail : plant->own <= exact_tail ? exact_tail : max_coordinates);
    auto parts =
        std::make_unique<TwinParts>(TwinParts{std::move(*plant), *controller, *sensors, steps, std::nullopt, {}});
    read_missions(image, *parts, fault);
    return parts;
}

/// Read start and world of a twin; returns why they cannot be, or nothing.
inline std::string read_start(const ht_start& start, const TwinParts& parts, const NamedColumns& columns, Run& run,
                              World& world) {
    run = {0, 1, parts.controller.tick, parts.steps, {{-start.speed, 0, 0}, {0, 0, 0}}, {}, 0};
    if (!start.sea) return "";
    ColumnReader in(columns);
    Sea<double> sea = read_sea<double>(in.row("sea", sea_columns).data());
    if (!in.fault().empty() || !parts.plant.space)
        return "twin: the robot is not described in space; add tables spatial and fins";
    std::copy(start.current, start.current + 2, sea.current);
    sea.bottom = start.bottom;
    world.sea = sea;
    // The body's first axis points to the tail.
    run.pose = {{0, 0, -start.depth}, {std::sin(start.heading / 2), 0, 0, -std::cos(start.heading / 2)}, {0, 0}};
    return "";
}

/// Set a command from a gait's row and the angles of the fins.
inline void set_command(Command<double>& to, int joints, const double* gait, const double* fins, bool armed) {
    to.frequency = gait[0];
    for (int j = 0; j < joints; ++j) {
        to.amplitude[j] = gait[1 + j];
        to.phase[j] = std::remainder(gait[1 + joints + j] - gait[1 + joints], 2 * pi);  // lag behind the first joint
        to.bias[j] = gait[1 + 2 * joints + j];
    }
    std::copy(fins, fins + 2, to.fin);
    to.fresh = true;
    to.armed = armed;
}

/// Name and width of a column of a row; null after the last.
inline const char* column(const Record& row, int index, int* width) {
    if (index < 0 || int(row.columns.size()) <= index) return nullptr;
    *width = int(row.columns[index].width);
    return row.columns[index].name.c_str();
}

/// All numbers of a row, column after column.
inline void read_row(const Record& row, double* to) {
    for (const RecordColumn& column : row.columns) to = std::copy(column.values.begin(), column.values.end(), to);
}

}  // namespace hypertuna
