/// Directions of derivatives in the space of a model's parameters.
#pragma once

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/host/load_model.hpp"

namespace hypertuna {

inline int parameter_count(const Model& model) {
    int count = 0;
    for (const ParameterColumn& column : parameter_columns(model)) count += column.count;
    return count;
}

/// Number of rows of a gait's directions: the parameters, then the share of each link's front joint.
inline int beat_rows(const Model& model) { return parameter_count(model) + model.links; }

/// Sort directions by whether they change parameters on which the shape of the body depends; `of_gait` where the rows
/// include the gait and the shares.
inline Directions sort_directions(const Model& model, const double* along, int count, bool of_gait) {
    Directions directions{along, count, {}, {}};
    if (of_gait) directions.still = {-3, -2, -1};
    const int end = shape_parameters(model.groups, model.links), begin = of_gait ? 0 : end - 2 * model.links;
    for (int k = 0; k < count; ++k) {
        bool moves = false;
        for (int i = begin; i < end; ++i) moves |= along[i * count + k] != 0;
        for (int i = parameter_count(model); of_gait && i < beat_rows(model); ++i) moves |= along[i * count + k] != 0;
        (moves ? directions.moving : directions.still).push_back(k);
    }
    return directions;
}

}  // namespace hypertuna
