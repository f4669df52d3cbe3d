/// The extension module: hypertuna's core as Python sees it.
#include "model.hpp"

NB_MODULE(_core, m) {
    m.doc() = "The numerical core: SI units and radians throughout, plain arrays in and out.";
    hypertuna::bind_model(m);
    hypertuna::bind_settle(m);
    hypertuna::bind_swimmer(m);
    hypertuna::bind_actuation(m);
    hypertuna::bind_control(m);
    hypertuna::bind_pilot(m);
    hypertuna::bind_simulation(m);
    hypertuna::bind_batch(m);
    hypertuna::bind_firmware(m);
    hypertuna::bind_film(m);
}
