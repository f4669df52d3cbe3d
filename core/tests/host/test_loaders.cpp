/// Loaders: named columns in, an object or a sentence out, without exceptions.
#include "check.hpp"
#include "hypertuna/host/controller.hpp"
#include "hypertuna/host/load_model.hpp"
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
    const double joints = 13;
    CHECK(load_sensors({{"joints", &joints, 1, 1}}, 0).fault == "joints: must be from 1 to 12");
}

/// Two links and one joint group, of a law without flags of its own.
static void a_model_is_laid_out_in_the_order_of_the_parameters() {
    const double one = 1, group[2] = {-1, 0}, share[2] = {0, 1}, bandwidth = 2, pairs[2] = {3, 4};
    NamedColumns columns = {{"body_length", &one, 1, 1},
                            {"joint_group", group, 2, 1},
                            {"joint_share", share, 2, 1},
                            {"bandwidth", &bandwidth, 1, 1},
                            {"phase_offset", &one, 1, 1}};
    CHECK(load_model("abacus", columns).fault == "law: must be one of lumped, strip, elongated");
    CHECK(load_model("strip", columns).fault == "columns: lacks length");
    for (const char* name : {"length", "com", "mass", "inertia"}) columns.push_back({name, pairs, 2, 1});
    columns.push_back({"density", &one, 1, 1});
    for (const WaterColumn& column : Strip<double>::columns)
        columns.push_back({column.name, column.per_link ? pairs : &one, std::size_t(column.per_link ? 2 : 1), 1});
    const Loaded<Model> model = load_model("strip", columns);
    CHECK(model.object && model.fault.empty() && model.object->links == 2 && model.object->groups == 1);
    CHECK(model.object->robot[0] == bandwidth && model.object->robot[2] == 3 && model.object->robot[3] == 4);
    const double reaching[2] = {-1, 1}, bent[2] = {0, 0};
    columns[1].data = reaching;
    CHECK(load_model("strip", columns).fault == "joint_group: must be -1 or a group");
    columns[1].data = bent;
    CHECK(load_model("strip", columns).fault == "joint_group: must be -1 for link 0, which has no front joint");
}

static void a_plant_without_its_columns_is_refused() {
    const Model model{0, 0, 2, 1, 1.0, {-1, 0}, {0, 1}, std::vector<double>(32)};
    const double share[2] = {0, 1}, joints = 1;
    const Loaded<PlantData> plant = load_plant(model, {{"share", share, 2, 1}, {"joints", &joints, 1, 1}});
    CHECK(!plant.object && plant.fault == "columns: lacks joint.outer");
}

int main() {
    a_world_without_columns_is_the_plane();
    a_missing_column_is_named();
    a_wrong_shape_is_refused();
    a_model_is_laid_out_in_the_order_of_the_parameters();
    a_plant_without_its_columns_is_refused();
    return failures();
}
