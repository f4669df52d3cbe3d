/// Water for MuJoCo: an engine plugin that lets the core's water act on a robot of an MJCF file.
///
/// `hypertuna export mjcf --plugin` writes the file: each link is a body with the link's own mass, and carries the
/// instance; in space the two pectoral fins stand right behind the head. Added mass goes into MuJoCo's mass matrix, at
/// the places that the links' own mass has in it, so that it is implicit for accelerations, constraints and implicit
/// integrators. All forces of the water are passive forces.
#include <mujoco/mujoco.h>

#include <cstdlib>
#include <limits>
#include <memory>
#include <sstream>

#include "hypertuna/host/body.hpp"
#include "hypertuna/host/load_model.hpp"
#include "ranges.hpp"

#if mjVERSION_HEADER < 4000000
#error "needs MuJoCo 4, whose mass matrix is stored by rows"
#endif

namespace hypertuna {
namespace {

using Law = WaterLaws::Any<double>;
using Links = std::vector<LinkSpace<double>>;

/// Columns parsed from the file's text, one after another: name, rows, width, numbers.
struct Text {
    static constexpr std::size_t most = 1000000;               // rows, width, and numbers of a column
    static constexpr NumberRange any{-huge, huge, false, ""};  // of excess, which images lack
    std::vector<std::vector<double>> numbers;
    NamedColumns columns;
    std::string fault;

    explicit Text(const char* text) {
        std::istringstream in(text);
        std::string name, word;
        std::size_t rows, width;
        while (in >> name >> rows >> width && rows <= most && width <= most && rows * width <= most) {
            std::vector<double>& column = numbers.emplace_back(rows * width);
            for (double& number : column) in >> word, number = std::strtod(word.c_str(), nullptr);  // inf is one
            columns.push_back({name, column.data(), rows, width});
            const NumberRange& range = name == "excess" ? any : range_of(name);
            for (const double number : column)
                if (!in_range(range, number)) fault = name + ": has a number that no robot has";
        }
    }
};

/// Description in space of a body in the plane: without mass or force outside the plane.
BodyData::Space flat(int links) {
    LinkBody<double> none{};
    none.height = 1;
    return {std::vector(links, none), make_fin(Vector<double>{0, 0, 0}, 0.0, 1.0, 0.3, 0.0, 1.0, 1.0), 0, 0};
}

/// The water around one robot: the core's body in space without the links' own mass, which MuJoCo already has.
struct Water {
    BodyData data;
    bool in_plane;
    SpaceBody<Law, 1> body;
    std::vector<LinkInertia<double>> added;
    Links space;
    std::vector<int> link, fin;           // bodies of MuJoCo
    std::vector<double> linear, angular;  // Jacobians, 3 x nv
    std::vector<double> jacobian,
        carried;  // Jacobian of a link in its own axes, 6 x nv, and the same times the link's added inertia

    /// `excess` (links x 3) is how far a link's moments of inertia about x, y and z exceed those of MuJoCo's body.
    Water(const BodyData& given, bool plane, const std::vector<double>& excess, std::vector<int> bodies, int nv)
        : data(given),
          in_plane(plane),
          body(data, still_water(data)),
          linear(3 * nv),
          angular(3 * nv),
          jacobian(6 * nv),
          carried(6 * nv) {
        const int links = data.model.links;
        const double density = body.body.sea.density;
        for (int i = 0; i < links; ++i) {
            const Link<double>& own = body.plane.tank.fish.link[i];
            LinkInertia<double> inertia = body.plane.tank.fish.water.inertia(i);
            inertia.tangential -= own.mass;
            inertia.normal -= own.mass;
            inertia.rotary -= own.inertia;
            LinkBody<double> massless = data.space->link[i];
            massless.com_height = 0;
            massless.roll = excess[3 * i];
            massless.pitch = excess[3 * i + 1];
            space.push_back(make_link_space(massless, Link<double>{own.length, own.com, 0, 0}, inertia, density));
            inertia.rotary += excess[3 * i + 2];
            added.push_back(inertia);
        }
        body.body.tail.fish.water.inertias = added.data();
        body.body.space = space.data();
        const bool with_fins = int(bodies.size()) == links + 2;
        if (with_fins) fin = {bodies[1], bodies[2]};
        link = {bodies[0]};
        link.insert(link.end(), bodies.begin() + (with_fins ? 3 : 1), bodies.end());
    }

    static Sea<double> still_water(const BodyData& data) {
        Sea<double> sea{};
        sea.density = data.model.robot[density_place(data.model.groups, data.model.links)];
        sea.bottom = std::numeric_limits<double>::infinity();
        return sea;
    }
};

/// Angle and rate of a body relative to its parent: the sums over the body's joints.
std::pair<double, double> hinge(const mjModel* m, const mjData* d, int body) {
    double angle = 0, rate = 0;
    for (int k = 0; k < m->body_jntnum[body]; ++k) {
        const int joint = m->body_jntadr[body] + k, at = m->jnt_qposadr[joint];
        angle += d->qpos[at] - m->qpos0[at], rate += d->qvel[m->jnt_dofadr[joint]];
    }
    return {angle, rate};
}

/// Add J^T f to the passive forces; J (6, nv) has its rows in the order of a LinkPair.
void push(mjData* d, const std::vector<double>& jacobian, int nv, const double (&f)[6]) {
    for (int row = 0; row < 6; ++row)
        for (int k = 0; k < nv; ++k) d->qfrc_passive[k] += jacobian[row * nv + k] * f[row];
}

/// Jacobian (6, nv) of a point of a body, in the body's axes: velocity, then rate.
void point_jacobian(const mjModel* m, const mjData* d, int body, double along, Water& water) {
    const mjtNum *axes = d->xmat + 9 * body, *origin = d->xpos + 3 * body;
    const mjtNum point[3] = {origin[0] + along * axes[0], origin[1] + along * axes[3], origin[2] + along * axes[6]};
    mj_jac(m, d, water.linear.data(), water.angular.data(), point, body);
    const int nv = int(m->nv);
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < nv; ++k) {
            double v = 0, w = 0;
            for (int x = 0; x < 3; ++x) {
                v += axes[3 * x + row] * water.linear[x * nv + k];
                w += axes[3 * x + row] * water.angular[x * nv + k];
            }
            water.jacobian[row * nv + k] = v;
            water.jacobian[(3 + row) * nv + k] = w;
        }
}

/// Add J^T Lambda J to the mass matrix; the core computes Lambda V.
void weigh(const mjModel* m, mjData* d, int i, Water& water) {
    const int nv = int(m->nv);
    const std::vector<double>& j = water.jacobian;
    for (int k = 0; k < nv; ++k) {
        const LinkPair<double> v{{j[k], j[nv + k], j[5 * nv + k]}, {j[2 * nv + k], j[3 * nv + k], j[4 * nv + k]}};
        const LinkPair<double> p = link_momentum(water.added[i], water.space[i], v);
        const double momentum[6] = {p.in.t, p.in.n, p.across.z, p.across.t, p.across.n, p.in.w};
        for (int row = 0; row < 6; ++row) water.carried[row * nv + k] = momentum[row];
    }
    for (int row = 0; row < nv; ++row)
        for (int at = m->M_rowadr[row]; at < m->M_rowadr[row] + m->M_rownnz[row]; ++at)
            for (int x = 0; x < 6; ++x) d->M[at] += j[x * nv + row] * water.carried[x * nv + m->M_colind[at]];
}

void act(const mjModel* m, mjData* d, Water& water) {
    const int head = water.link[0], nv = int(m->nv);
    Body6<double, Law, 1>& body = water.body.body;
    const Tail<double, Law, 1>& tail = body.tail;
    for (int i = 0; i < tail.fish.links; ++i) {
        const auto [angle, rate] = i == 0 ? std::pair(0.0, 0.0) : hinge(m, d, water.link[i]);
        tail.joint[i] = {angle, rate, 0};
    }
    shape(tail.fish.links, tail.fish.link, tail.joint, tail.shape, tail.acceleration);

    mjtNum velocity[6];  // rate, then velocity of the nose, in the head's axes
    mj_objectVelocity(m, d, mjOBJ_XBODY, head, velocity, 1);
    const SpatialTwist<double> xi{{velocity[3], velocity[4], velocity[5]}, {velocity[0], velocity[1], velocity[2]}};
    const mjtNum *place = d->xpos + 3 * head, *turn = d->xquat + 4 * head;
    Pose6<double> pose{
        {place[0], place[1], water.in_plane ? -1e9 : place[2]}, {turn[0], turn[1], turn[2], turn[3]}, {}};
    for (std::size_t side = 0; side < water.fin.size(); ++side) pose.fin[side] = hinge(m, d, water.fin[side]).first;
    const Outlook<double> out = look_out(body, pose, xi);
    // MuJoCo's bias is for a nose at constant velocity in world axes, the core's for constant velocity in body axes.
    const Vector<double> turning = cross(xi.linear, xi.angular);

    mj_makeM(m, d);  // without the water that the last call added
    for (int i = 0; i < tail.fish.links; ++i) {
        const LinkShape<double>& at = tail.shape[i];
        const LinkPair<double> load = link_load(body, i, LinkView<double>(at), xi, out);
        const LinkPair<double> change = link_momentum(
            water.added[i], water.space[i], {at.along(Twist<double>{turning.x, turning.y, 0}), {turning.z, 0, 0}});
        point_jacobian(m, d, water.link[i], tail.fish.link[i].com, water);
        push(d, water.jacobian, nv,
             {-load.in.t - change.in.t, -load.in.n - change.in.n, -load.across.z - change.across.z,
              -load.across.t - change.across.t, -load.across.n - change.across.n, -load.in.w - change.in.w});
        weigh(m, d, i, water);
    }
    BodyEquations<double, 1> fins{};
    push_head(body, pose, xi, out, fins);
    point_jacobian(m, d, head, 0, water);
    push(d, water.jacobian, nv,
         {fins.tail.load.x, fins.tail.load.y, fins.load.z, fins.load.t, fins.load.n, fins.tail.load.z});
    mj_factorM(m, d);
}

int init(const mjModel* m, mjData* d, int instance) {
    const auto refuse = [](const std::string& sentence) {
        mju_warning("hypertuna.water: %s", sentence.c_str());
        return -1;
    };
    d->plugin_data[instance] = 0;
    const char *const law = mj_getPluginConfig(m, instance, "law"), *const columns =
                                                                        mj_getPluginConfig(m, instance, "columns");
    if (!law || !columns) return refuse("must have law and columns, as `hypertuna export mjcf --plugin` writes them");
    const Text text(columns);
    if (!text.fault.empty()) return refuse(text.fault);
    const Loaded<Model> model = load_model(law, text.columns);
    if (!model.object) return refuse(model.fault);
    const int links = model.object->links;
    ColumnReader in(text.columns);
    BodyData data = read_body_data(in, *model.object);
    const std::vector<double> excess = in.numbers("excess", links, 3);
    if (!in.fault().empty()) return refuse(in.fault());
    const bool plane = !data.space;
    if (plane) data.space = flat(links);
    std::vector<int> bodies;
    for (int body = 0; body < m->nbody; ++body)
        if (m->body_plugin[body] == instance) bodies.push_back(body);
    if (const int count = int(bodies.size()); count != links && count != links + 2)
        return refuse("must be the plugin of " + std::to_string(links) + " bodies, but is of " + std::to_string(count));
    d->plugin_data[instance] =
        reinterpret_cast<std::uintptr_t>(new Water(data, plane, excess, std::move(bodies), int(m->nv)));
    return 0;
}

void destroy(mjData* d, int instance) {
    delete reinterpret_cast<Water*>(d->plugin_data[instance]);
    d->plugin_data[instance] = 0;
}

mjPLUGIN_LIB_INIT(hypertuna_water) {
    static const char* const attributes[] = {"law", "columns"};
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "hypertuna.water";
    plugin.capabilityflags = mjPLUGIN_PASSIVE;
    plugin.nattribute = 2;
    plugin.attributes = attributes;
    plugin.nstate = [](const mjModel*, int) { return 0; };
    plugin.init = init;
    plugin.destroy = destroy;
    plugin.reset = [](const mjModel*, mjtNum*, void*, int) {};
    plugin.compute = [](const mjModel* m, mjData* d, int instance, int) {
        act(m, d, *reinterpret_cast<Water*>(d->plugin_data[instance]));
    };
    mjp_registerPlugin(&plugin);
}

}  // namespace
}  // namespace hypertuna
