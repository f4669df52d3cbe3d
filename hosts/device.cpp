/// The C interface of device.h.
#include "device.h"

#include "robot.hpp"
// included apart, since the names of the settled beat come first
#include "device.hpp"

using namespace hypertuna;

struct ht_device {
    std::unique_ptr<TwinParts> parts;
    std::unique_ptr<LiveTwin> live;
};

extern "C" {

ht_device* ht_device_create(const unsigned char* bytes, size_t size, const ht_start* start, int plant, char* fault,
                            size_t room) {
    std::string wrong;
    const std::optional<Image> image = take(read_image(bytes, size), wrong);
    const std::optional<HostModel> model = image ? read_model(image->part("models.0."), wrong) : std::nullopt;
    if (model && image->part("plant.").empty()) wrong = no_controller;
    std::unique_ptr<TwinParts> parts = wrong.empty() ? read_twin(*image, model->model, wrong) : nullptr;
    Run run{};
    World world{};
    if (wrong.empty()) wrong = read_start(*start, *parts, image->part("world."), run, world);
    tell(wrong, fault, room);
    if (!wrong.empty()) return nullptr;
    std::unique_ptr<LiveTwin> live = with_tail(parts->plant, [&](auto tail) {
        return Devices<tail.value>::start(*parts, start->seed, run, world, plant != 0);
    });
    return new ht_device{std::move(parts), std::move(live)};
}
void ht_device_free(ht_device* device) { delete device; }
int ht_device_joints(const ht_device* device) { return device->parts->controller.joints; }
double ht_device_tick(const ht_device* device) { return device->parts->controller.tick; }

void ht_device_command(ht_device* device, const double* gait, const double fins[2], int armed) {
    set_command(device->live->command, ht_device_joints(device), gait, fins, armed != 0);
}
void ht_device_drive(ht_device* device, const double* pulses) {
    const Controller<double>& limits = device->parts->controller;
    for (int k = 0; k < servos_of(limits.joints); ++k)
        device->live->pulse[k] = clamp(pulses[k], limits.pulse_min, limits.pulse_max);
}
int ht_device_steer(ht_device* device, int steered, double depth, double heading) {
    if (!device->live->piloted()) return 0;
    const double deepest = device->parts->pilot->estimator.depth_high;
    device->live->steered = {steered != 0, clamp(depth, 0.0, deepest), {std::cos(heading), std::sin(heading)}};
    return 1;
}
void ht_device_flow(ht_device* device, const double current[2]) { device->live->flow(current); }

int ht_device_advance(ht_device* device, int ticks) { return device->live->advance(ticks); }
const char* ht_device_column(const ht_device* device, int index, int* width) {
    return column(device->live->row, index, width);
}
void ht_device_read(const ht_device* device, double* row) { read_row(device->live->row, row); }

size_t ht_device_state_size(const ht_device* device) { return device->live->state_size(); }
void ht_device_save(const ht_device* device, unsigned char* state) { device->live->save(state); }
int ht_device_restore(ht_device* device, const unsigned char* state, size_t size) {
    if (size != device->live->state_size()) return 0;
    device->live->restore(state);
    return 1;
}

}  // extern "C"
