/// Binding of the silhouette that is fitted to the frames of a film.
#include "hypertuna/host/silhouette.hpp"
#include "model.hpp"

namespace hypertuna {

template <class Array>
static std::span<const double> numbers(const Array& array) {
    return {array.data(), array.size()};
}

static Silhouette body_of(const Input<1>& length, const Input<2>& share, const Input<2>& section) {
    check_extent("share", share.shape(0), length.shape(0));
    check_extent("section", section.shape(1), 2);
    if (length.shape(0) == 0 || section.shape(0) < 3)
        throw nb::value_error("a silhouette has a link and three stations at least");
    return {numbers(length), numbers(share), numbers(section), share.shape(1)};
}

static std::span<const Pixel> pixels_of(const Input<2>& pixels) {
    check_extent("pixels", pixels.shape(1), sizeof(Pixel) / sizeof(double));
    return {reinterpret_cast<const Pixel*>(pixels.data()), pixels.shape(0)};
}

static NamedArrays fit(const Input<2>& pixels, const Input<1>& length, const Input<2>& share, const Input<2>& section,
                       const Input<1>& start, const Input<1>& mean, const Input<1>& precision, const Input<2>& stages,
                       double loss, int iterations) {
    const Silhouette body = body_of(length, share, section);
    const std::size_t n = body.unknowns();
    check_extent("start", start.shape(0), n);
    check_extent("mean", mean.shape(0), n);
    check_extent("precision", precision.shape(0), n);
    check_extent("stages", stages.shape(1), sizeof(Stage) / sizeof(double));
    if (stages.shape(0) == 0) throw nb::value_error("stages: a fit has one at least");
    const std::span<const Stage> steps{reinterpret_cast<const Stage*>(stages.data()), stages.shape(0)};
    SilhouetteProblem problem(body, pixels_of(pixels), {numbers(mean), numbers(precision), loss});
    const SilhouetteFit found = problem.solve({start.data(), start.data() + n}, steps, iterations);
    Output unknowns = zeros({n}), information = zeros({n, n}), seen = zeros({found.seen.size()}), size = zeros({2});
    std::copy(found.unknowns.begin(), found.unknowns.end(), unknowns.data());
    std::copy(found.information.begin(), found.information.end(), information.data());
    std::copy(found.seen.begin(), found.seen.end(), seen.data());
    size.data()[0] = found.noise;
    size.data()[1] = found.offset;
    NamedArrays out;
    out["unknowns"] = unknowns;
    out["information"] = information;
    out["seen"] = seen;
    out["noise_offset"] = size;
    return out;
}

/// Values (pixels,), derivatives (pixels, unknowns), and distances inside the edge (pixels,) [m].
static NamedArrays draw(const Input<2>& pixels, const Input<1>& length, const Input<2>& share, const Input<2>& section,
                        const Input<1>& unknowns, double edge) {
    const Silhouette body = body_of(length, share, section);
    const std::size_t n = body.unknowns();
    check_extent("unknowns", unknowns.shape(0), n);
    const std::span<const Pixel> points = pixels_of(pixels);
    Output value = zeros({points.size()}), by = zeros({points.size(), n}), inside = zeros({points.size()});
    const PosedBody posed(body, numbers(unknowns));
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto at = posed.near(points[k]);
        value.data()[k] = posed.shown(points[k], at, edge, {by.data() + k * n, n});
        inside.data()[k] = at.inside;
    }
    NamedArrays out;
    out["value"] = value;
    out["by"] = by;
    out["inside"] = inside;
    return out;
}

void bind_film(nb::module_& m) {
    m.def("fit_silhouette", &fit, nb::arg("pixels"), nb::arg("length"), nb::arg("share"), nb::arg("section"),
          nb::arg("start"), nb::arg("mean"), nb::arg("precision"), nb::arg("stages"), nb::arg("loss"),
          nb::arg("iterations"), "Fit the silhouette of a chain to pixels (m, 5): x, y, lean of the sight, value.");
    m.def("draw_silhouette", &draw, nb::arg("pixels"), nb::arg("length"), nb::arg("share"), nb::arg("section"),
          nb::arg("unknowns"), nb::arg("edge"), "Draw the silhouette: values, derivatives, distances inside its edge.");
}

}  // namespace hypertuna
