/// Loaders: named columns in, an object or a sentence out, without exceptions.
#include "check.hpp"
#include "hypertuna/host/controller.hpp"
#include "hypertuna/host/plant.hpp"

using namespace hypertuna;

static void a_world_without_columns_is_the_plane() {
    const Loaded<World> world = load_world({});
    CHECK(world.object && !world.object->clamped && !world.object->sea && world.object->gaps.empty());
}

static void a_missing_column_is_named() {
    const double density = 1000;
    const Loaded<World> world = load_world({{"sea.density", &density, 1, 1}});
    CHECK(!world.object && world.fault == "columns: lacks sea.current_east");
    CHECK(load_controller({}).fault == "columns: lacks joints");
    CHECK(load_mission({}).fault == "columns: lacks waypoints");
}

static void a_wrong_shape_is_refused() {
    const double gaps[3] = {1, 2, 3};
    CHECK(load_world({{"gaps", gaps, 3, 1}}).fault == "gaps: shape must be (3, 2), but is (3, 1)");
    const double joints = 5;
    CHECK(load_sensors({{"joints", &joints, 1, 1}}, 0).fault == "joints: must be from 1 to 4");
}

static void a_plant_without_its_columns_is_refused() {
    const Model model{0, 0, 2, 1, 1.0, {-1, 0}, {0, 1}, std::vector<double>(32)};
    const double share[2] = {0, 1}, joints = 1;
    const Loaded<PlantData> plant = load_plant(model, {{"share", share, 2, 1}, {"joints", &joints, 1, 1}});
    CHECK(!plant.object && plant.fault == "columns: lacks points[0]");
}

int main() {
    a_world_without_columns_is_the_plane();
    a_missing_column_is_named();
    a_wrong_shape_is_refused();
    a_plant_without_its_columns_is_refused();
    return failures();
}
