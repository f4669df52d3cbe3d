/// Silhouette: a chain of links seen from above, drawn with a soft edge and fitted to the pixels of a frame.
///
/// Sections are ellipses. A line of sight that leans by `k` (horizontal way per height) sees the half width
/// sqrt(a^2 + (b k.n)^2) of a section of half width a and half height b, n the normal of its link. How much
/// of a pixel the body covers is the normal distribution of its distances to both sides, so that a fin thinner than a
/// pixel counts, too.
/// Unknowns: x, y, heading of the nose, an angle per joint group, log of the size, log of the girth, contrast.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace hypertuna {

/// Description of the body.
struct Silhouette {
    std::span<const double> length;   // m, of each link
    std::span<const double> share;    // (links, groups): heading of a link = that of the head + share . angles
    std::span<const double> section;  // (stations, 2): a^2, b^2 [m^2], evenly spaced from nose to tail tip
    std::size_t groups;

    std::size_t unknowns() const { return 6 + groups; }
    std::size_t size() const { return 3 + groups; }  // index of the logarithm of the size
};

/// Place, lean of the line of sight and value of a pixel: x, y [m], k_x, k_y [1], gray levels.
struct Pixel {
    double x, y, lean_x, lean_y, value;
};

/// A body in a pose: the axes of its links, and how their front ends move with the unknowns.
class PosedBody {
  public:
    PosedBody(const Silhouette& body, std::span<const double> u) : body_(body), n_(body.unknowns()) {
        const std::size_t links = body.length.size();
        scale_ = std::exp(u[body.size()]);
        girth_ = std::exp(2 * u[body.size() + 1]);
        contrast_ = u[body.size() + 2];
        double x = u[0], y = u[1], from = 0.0;
        std::vector<double> move_x(n_, 0.0), move_y(n_, 0.0);
        move_x[0] = move_y[1] = 1.0;
        for (std::size_t i = 0; i < links; ++i) {
            double heading = u[2];
            for (std::size_t g = 0; g < body.groups; ++g) heading += body.share[i * body.groups + g] * u[3 + g];
            Link link{x, y, std::cos(heading), std::sin(heading), scale_ * body.length[i], from, move_x, move_y, {}};
            link.turn.assign(n_, 0.0);
            link.turn[2] = 1.0;
            for (std::size_t g = 0; g < body.groups; ++g) link.turn[3 + g] = body.share[i * body.groups + g];
            x += link.length * link.cos;
            y += link.length * link.sin;
            from += body.length[i];
            for (std::size_t k = 0; k < n_; ++k) {
                move_x[k] -= link.length * link.sin * link.turn[k];
                move_y[k] += link.length * link.cos * link.turn[k];
            }
            move_x[body.size()] += link.length * link.cos;
            move_y[body.size()] += link.length * link.sin;
            links_.push_back(std::move(link));
        }
        step_ = from / double(body.section.size() / 2 - 1);
    }

    /// The part of the body nearest to a pixel: its link, and the signed distance to its edge, positive inside.
    struct Near {
        std::size_t link;
        double along, across;  // m from the link's front end, and to the left of its axis or from its end
        bool beyond;           // whether `across` is the distance to an end of the link
        double inside, other;  // m: distances to the near and the far edge
        double square, slope;  // square of the half width seen
    };

    /// Find the nearest part; where the axis is farther than `reach` [m] there is none, and the pixel counts as far
    /// outside.
    Near near(const Pixel& p, double reach = HUGE_VAL) const {
        Near best{0, 0, 0, false, -HUGE_VAL, 0, 0, 0};
        double least = reach * reach;
        for (std::size_t i = 0; i < links_.size(); ++i) {
            const Link& link = links_[i];
            const double x = p.x - link.x, y = p.y - link.y;
            const double along = link.cos * x + link.sin * y, across = link.cos * y - link.sin * x;
            const double low = i == 0 ? -HUGE_VAL : 0.0, high = i + 1 == links_.size() ? HUGE_VAL : link.length;
            const double at = std::clamp(along, low, high), over = along - at;
            const double distance = over * over + across * across + (i + 1 == links_.size() ? past(link, along) : 0.0);
            if (distance < least) {
                least = distance;
                best = {i, at, over == 0.0 ? across : std::sqrt(over * over + across * across), over != 0.0, 0, 0,
                        0, 0};
            }
        }
        if (best.inside == 0) measure(p, best);
        return best;
    }

    /// Value of a pixel by the drawn body, and its derivatives with respect to the unknowns in `by`; `edge` is the
    /// standard deviation of the blur [m].
    double shown(const Pixel& p, const Near& at, double edge, std::span<double> by) const {
        std::fill(by.begin(), by.end(), 0.0);
        if (at.inside < -FAR * edge) return 0.0;
        const Link& link = links_[at.link];
        const bool last = at.link + 1 == links_.size();
        if (at.inside > FAR * edge && at.other > FAR * edge && !(last && link.length - at.along < FAR * edge)) {
            by[body_.size() + 2] = 1.0;
            return contrast_;
        }
        const double inner = normal(at.inside / edge), outer = normal(at.other / edge);
        const double cover = std::max(inner + outer - 1, 0.0);
        const double end = last ? normal((link.length - at.along) / edge) : 1.0;
        by[body_.size() + 2] = cover * end;
        const double value = contrast_ * cover * end;
        if (cover <= 0 || cover * end > 1 - 1e-7) return value;
        const double a = std::sqrt(std::max(at.square, 1e-12)), d = std::abs(at.across), sign = at.across < 0 ? -1 : 1;
        const double other_d = (a + d) / at.other * sign;
        const double other_a = at.square > 1e-12 ? (a + d) / at.other / (2 * a) : 0.0;
        const double inside_a = (1 - at.inside * other_a) / at.other;
        const double inside_d = (-2 * at.across - at.inside * other_d) / at.other;
        const double dense_in = density(at.inside / edge) / edge, dense_out = density(at.other / edge) / edge;
        const double by_a = contrast_ * end * (dense_in * inside_a + dense_out * other_a);
        const double by_d = contrast_ * end * (dense_in * inside_d + dense_out * other_d);
        const double by_end = last ? contrast_ * cover * density((link.length - at.along) / edge) / edge : 0.0;
        const double lean = p.lean_y * link.cos - p.lean_x * link.sin, tall = 2 * lean * scale_ * scale_ * high(at);
        const double lean_along = p.lean_x * link.cos + p.lean_y * link.sin;
        const double x = p.x - link.x, y = p.y - link.y;
        const double along = link.cos * x + link.sin * y, across = link.cos * y - link.sin * x;
        for (std::size_t k = 0; k < body_.size() + 1; ++k) {
            const double mx = link.move_x[k], my = link.move_y[k], turn = link.turn[k];
            double along_k = -(link.cos * mx + link.sin * my) + across * turn;
            double across_k = link.sin * mx - link.cos * my - along * turn;
            const bool sized = k == body_.size();
            if (at.beyond) {  // the distance to an end of the link, which moves with it
                const double over = along - at.along, moved = sized ? at.along : 0.0;
                across_k = (over * (along_k - moved) + across * across_k) / at.across;
                along_k = moved;
            }
            const double square_k = at.slope * (along_k - (sized ? at.along : 0.0)) + (sized ? 2 * at.square : 0.0) -
                                    tall * lean_along * turn;
            by[k] = by_a * square_k + by_d * across_k + by_end * ((sized ? link.length : 0.0) - along_k);
        }
        by[body_.size() + 1] = by_a * 2 * scale_ * scale_ * girth_ * wide(at);
        return value;
    }

    /// How fast a pixel's value changes with its distance to the edge [gray levels per m].
    double steepness(const Near& at, double edge) const { return contrast_ * density(at.inside / edge) / edge; }

    /// Whether a place is in the rear half of its link.
    bool rear(const Near& at) const { return at.along > 0.5 * links_[at.link].length; }

    /// The largest half width seen along a line of sight of this lean [m].
    double widest(double lean) const {
        double most = 0;
        for (std::size_t k = 0; k + 1 < body_.section.size(); k += 2)
            most = std::max(most, girth_ * body_.section[k] + lean * lean * body_.section[k + 1]);
        return scale_ * std::sqrt(most);
    }

  private:
    static constexpr double FAR =
        5.0;  // distance from an edge, in standard deviations of the blur, beyond which a pixel does not see the edge

    struct Link {
        double x, y, cos, sin, length,
            from;  // m: front end, axis, length; distance of the front end from the nose before scaling
        std::vector<double> move_x, move_y,
            turn;  // derivatives of the front end and of the heading with respect to the unknowns
    };

    static double normal(double t) { return 0.5 * std::erfc(-t * 0.70710678118654752); }
    static double density(double t) { return 0.39894228040143268 * std::exp(-0.5 * t * t); }
    static double past(const Link& link, double along) {
        const double over = std::max(along - link.length, 0.0);
        return over * over;
    }

    /// Number of the sections between two stations, continued in a straight line beyond the nose, and its slope along
    /// the body.
    std::pair<double, double> column(const Near& at, int which) const {
        const std::size_t stations = body_.section.size() / 2;
        const double place = (links_[at.link].from + at.along / scale_) / step_;
        const std::size_t left = std::size_t(std::clamp(std::floor(place), 0.0, double(stations - 2)));
        const double part = std::min(place - double(left), 1.0);
        const auto value = [&](std::size_t k) { return body_.section[2 * k + which]; };
        const auto slope = [&](std::size_t k) {
            const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, stations - 1);
            return (value(after) - value(before)) / (double(after - before) * step_);
        };
        const double in = std::clamp(part, 0.0, 1.0);
        return {value(left) + part * (value(left + 1) - value(left)), slope(left) * (1 - in) + slope(left + 1) * in};
    }
    double wide(const Near& at) const { return column(at, 0).first; }
    double high(const Near& at) const { return std::max(column(at, 1).first, 0.0); }

    void measure(const Pixel& p, Near& at) const {
        const Link& link = links_[at.link];
        const double lean = p.lean_y * link.cos - p.lean_x * link.sin;
        const auto [width, width_slope] = column(at, 0);
        const auto [height, height_slope] = column(at, 1);
        at.square = scale_ * scale_ * (girth_ * width + lean * lean * height);
        at.slope = scale_ * (girth_ * width_slope + lean * lean * height_slope);
        const double a = std::sqrt(std::max(at.square, 1e-12)), d = std::abs(at.across);
        at.other = std::sqrt(at.slope * at.slope + (a + d) * (a + d));
        at.inside = (at.square - d * d) / at.other;
    }

    const Silhouette& body_;
    std::size_t n_;
    double scale_, girth_, contrast_, step_;
    std::vector<Link> links_;
};

/// A stage of a fit: the first one has a soft edge, the last one a sharp edge.
struct Stage {
    double edge;  // m, standard deviation of the blur
    double band;  // m: pixels farther from the edge do not count
};

struct FitPrior {
    std::span<const double> mean,
        precision;  // mean and precision of the unknowns; precision is multiplied by the squared noise of a pixel
    double loss;    // gray levels: residuals above this count little (Cauchy loss)
};

struct SilhouetteFit {
    std::vector<double> unknowns, information;  // information of the pixels alone, times their squared noise
    std::vector<double> seen;                   // by link: 1 if the pixels show all of its rear half
    double noise, offset;                       // gray levels; m: distance of the seen edges from the drawn ones
};

class SilhouetteProblem {
  public:
    SilhouetteProblem(const Silhouette& body, std::span<const Pixel> pixels, const FitPrior& prior)
        : body_(body), all_(pixels), prior_(prior), n_(body.unknowns()) {}

    SilhouetteFit solve(std::vector<double> u, std::span<const Stage> stages, int iterations) {
        for (const Stage& stage : stages) {
            choose(u, stage);
            u = minimize(std::move(u), stage.edge, iterations, &stage == &stages.back() ? 1e-6 : 1e-3);
        }
        return result(u, stages.back().edge);
    }

  private:
    struct Sums {
        double cost = 0;
        std::vector<double> gradient, matrix;
    };

    void choose(const std::vector<double>& u, const Stage& stage) {
        const PosedBody body(body_, u);
        pixels_.clear();
        double lean = 0;
        for (const Pixel& p : all_) lean = std::max(lean, std::hypot(p.lean_x, p.lean_y));
        const double reach = body.widest(lean) + stage.band;
        for (const Pixel& p : all_) {
            const double inside = body.near(p, reach).inside;
            if (std::isfinite(p.value) && inside > -stage.band && inside < stage.band) pixels_.push_back(p);
        }
    }

    Sums sums(const std::vector<double>& u, double edge, bool with_prior) const {
        Sums out{0, std::vector<double>(n_, 0.0), std::vector<double>(n_ * n_, 0.0)};
        const PosedBody body(body_, u);
        std::vector<double> by(n_);
        const double scale = 1 / (prior_.loss * prior_.loss);
        for (const Pixel& p : pixels_) {
            const double r = body.shown(p, body.near(p), edge, by) - p.value, weight = 1 / (1 + r * r * scale);
            out.cost += 0.5 * std::log1p(r * r * scale) / scale;
            for (std::size_t i = 0; i < n_; ++i) {
                if (by[i] == 0) continue;
                out.gradient[i] += weight * r * by[i];
                for (std::size_t j = 0; j <= i; ++j) out.matrix[i * n_ + j] += weight * by[i] * by[j];
            }
        }
        for (std::size_t i = 0; i < n_; ++i) {
            for (std::size_t j = 0; j < i; ++j) out.matrix[j * n_ + i] = out.matrix[i * n_ + j];
            if (!with_prior) continue;
            const double off = u[i] - prior_.mean[i];
            out.cost += 0.5 * prior_.precision[i] * off * off;
            out.gradient[i] += prior_.precision[i] * off;
            out.matrix[i * n_ + i] += prior_.precision[i];
        }
        return out;
    }

    /// Minimize the cost by the method of Levenberg and Marquardt.
    std::vector<double> minimize(std::vector<double> u, double edge, int iterations, double enough) const {
        Sums now = sums(u, edge, true);
        double damping = 1e-4;
        for (int iteration = 0; iteration < iterations && damping < 1e6; ++iteration) {
            std::vector<double> step = now.gradient;
            if (!solved(now.matrix, damping, step)) {
                damping *= 10;
                continue;
            }
            std::vector<double> trial = u;
            for (std::size_t i = 0; i < n_; ++i) trial[i] -= step[i];
            Sums trial_sums = sums(trial, edge, true);
            const double won = now.cost - trial_sums.cost;
            if (!(won >= 0)) {
                damping *= 10;
                continue;
            }
            u = std::move(trial);
            now = std::move(trial_sums);
            damping = std::max(damping / 10, 1e-9);
            if (won < enough * now.cost) break;
        }
        return u;
    }

    /// Solve a damped symmetric system in place by Cholesky's factors; false if it is not positive.
    bool solved(std::vector<double> m, double damping, std::vector<double>& b) const {
        for (std::size_t i = 0; i < n_; ++i) m[i * n_ + i] += damping * m[i * n_ + i] + 1e-30;
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = m[i * n_ + j];
                for (std::size_t k = 0; k < j; ++k) sum -= m[i * n_ + k] * m[j * n_ + k];
                if (i == j && !(sum > 0)) return false;
                m[i * n_ + j] = i == j ? std::sqrt(sum) : sum / m[j * n_ + j];
            }
        for (std::size_t i = 0; i < n_; ++i) {
            for (std::size_t k = 0; k < i; ++k) b[i] -= m[i * n_ + k] * b[k];
            b[i] /= m[i * n_ + i];
        }
        for (std::size_t i = n_; i-- > 0;) {
            for (std::size_t k = i + 1; k < n_; ++k) b[i] -= m[k * n_ + i] * b[k];
            b[i] /= m[i * n_ + i];
        }
        return true;
    }

    SilhouetteFit result(const std::vector<double>& u, double edge) const {
        const PosedBody body(body_, u);
        const double contrast = u[n_ - 1];
        std::vector<double> by(n_), drawn(body_.length.size(), 0.0), there(body_.length.size(), 0.0);
        double squares = 0, weights = 0, near_squares = 0, steep = 0;
        for (const Pixel& p : pixels_) {
            const auto at = body.near(p);
            const double shown = body.shown(p, at, edge, by), r = shown - p.value;
            const double weight = 1 / (1 + r * r / (prior_.loss * prior_.loss));
            squares += weight * r * r;
            weights += weight;
            if (at.link == 0 || body.rear(at)) {  // the front of a link hides behind the link before
                drawn[at.link] += shown * shown;
                there[at.link] += shown * p.value;
            }
            if (at.inside < 3 * edge) {
                near_squares += r * r;
                steep += body.steepness(at, edge) * body.steepness(at, edge);
            }
        }
        std::vector<double> seen(drawn.size());
        for (std::size_t i = 0; i < seen.size(); ++i)
            seen[i] = drawn[i] > 0 && contrast != 0 ? there[i] / drawn[i] : 0.0;
        return {u, sums(u, edge, false).matrix, seen, std::sqrt(squares / std::max(weights - double(n_), 1.0)),
                std::sqrt(near_squares / steep)};
    }

    Silhouette body_;
    std::span<const Pixel> all_;
    FitPrior prior_;
    std::size_t n_;
    std::vector<Pixel> pixels_;
};

}  // namespace hypertuna
