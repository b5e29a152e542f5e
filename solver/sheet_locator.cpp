#include "solver/sheet_locator.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace caustic::solver {

namespace {

constexpr std::size_t kBins = 64;  // a side
// The image of a cell reaches beyond its samples by at most this share of their spread: exploration
// refines cells whose images are not nearly what gradients say.
constexpr double kImageMargin = 0.3;
// A cell in which a falls to this share of its largest value may hold a fold: samples are as dense
// as its gradients say.
constexpr double kNearFold = 0.12;
constexpr int kMaxNewton = 30;
// Beyond a fold there is no root, and the gap does not close: towards one on the fold itself it
// falls to a quarter each step, and in some steps of the greatest length by more than that too.
constexpr int kPatience = 4;
constexpr double kLeastProgress = 0.5;
// Newton's steps are no longer than this many radii of the cell, and its end no further from it.
constexpr double kLongestStep = 0.5;
constexpr double kFurthest = 1.5;
constexpr double kFurthestGuess = 2.5;
constexpr std::size_t kSheetsOfFold = 2;
constexpr double kLocatorRoundings = 4.0;
constexpr double kFineRounding = 1e-12;
// Roots nearer than this share of a cell are one.
constexpr double kOneRoot = 1e-6;
// On the domain's boundary to rounding is inside.
constexpr double kDomainRoundings = 100.0;

// Newton's method for q(x) = q on the surface.
std::optional<FieldPoint> newton_to(const Vec2& q, const FieldPoint& start, double radius,
                                    Evaluator& evaluate) {
  FieldPoint at = start;
  double previous = geometry::kInfinity, some_steps_ago = geometry::kInfinity;
  for (int i = 0; i < kMaxNewton; ++i) {
    // Beyond the receiver's plane it goes on smoothly, beyond a pole it does not.
    if (!at.finite || !(at.facing * start.facing > 0.0) ||
        (at.x - start.x).norm() > 2.0 * kFurthest * radius)
      return std::nullopt;
    const Vec2 dq = q - at.q;
    const double left = dq.norm(), stretch = std::sqrt(at.q_s.squaredNorm() + at.q_t.squaredNorm());
    const double rounding = kLocatorRoundings * (stretch * evaluate.map().rounding(at.x) +
                                                 geometry::kEpsilon * q.norm());
    const double nearly = 1e6 * rounding;  // where rounding inside of q may be the limit
    // Where rounding may be much, not before it is met.
    const bool as_near_as_can_be = rounding <= kFineRounding * q.norm() || left >= 0.5 * previous;
    if ((left <= rounding && as_near_as_can_be) ||
        (i > 8 && left >= 0.5 * previous && left <= nearly))
      return at;
    previous = left;
    if (i % kPatience == kPatience - 1) {
      if (left > kLeastProgress * some_steps_ago && left > nearly) return std::nullopt;
      some_steps_ago = left;
    }
    Vec3 step = at.pull_back(dq);
    const double length = step.norm();
    if (!std::isfinite(length)) return std::nullopt;
    if (length > kLongestStep * radius) step *= kLongestStep * radius / length;
    at = evaluate.on_surface(at.x + step, at.hits.get());
  }
  return std::nullopt;
}

}  // namespace

std::size_t SheetLocator::bin(const Vec2& q, int axis) const {
  const double half = field_.map.receiver().half[axis];
  const double share = 0.5 * (q[axis] / half + 1.0) * double(kBins);
  return static_cast<std::size_t>(std::clamp(share, 0.0, double(kBins - 1)));
}

SheetLocator::SheetLocator(const FamilyField& field) : field_(field), bins_(kBins * kBins) {
  const Exploration& e = field.exploration;
  for (const Cell& cell : e.cells) {
    Image image{Vec2::Constant(geometry::kInfinity), Vec2::Constant(-geometry::kInfinity), false};
    double least = geometry::kInfinity, largest = -geometry::kInfinity;
    const auto include = [&](const FieldPoint& f, bool clipped) {
      if (!f.finite || (!clipped && !f.arrives())) return;
      image.lo = image.lo.cwiseMin(f.q);
      image.hi = image.hi.cwiseMax(f.q);
      least = std::min(least, f.a);
      largest = std::max(largest, f.a);
    };
    for (const Corner& corner : cell.polygon)
      include(e.samples[corner.sample], corner.boundary >= 0);
    include(e.samples[cell.center], false);
    // Near zero at a corner it may change its sign between samples.
    image.folded =
        least * largest <= 0.0 || std::min(std::abs(least), std::abs(largest)) <
                                      kNearFold * std::max(std::abs(least), std::abs(largest));
    const Vec2 more = Vec2::Constant(kImageMargin * (image.hi - image.lo).norm());
    image.lo -= more;
    image.hi += more;
    const int id = static_cast<int>(images_.size());
    images_.push_back(image);
    if (!(image.lo.x() <= image.hi.x())) continue;
    for (std::size_t i = bin(image.lo, 0); i <= bin(image.hi, 0); ++i) {
      for (std::size_t j = bin(image.lo, 1); j <= bin(image.hi, 1); ++j)
        bins_[j * kBins + i].push_back(id);
    }
  }
}

std::vector<FieldPoint> SheetLocator::at(const Vec2& q, Evaluator& evaluate) const {
  std::vector<FieldPoint> found;
  std::vector<int> tried;
  const Exploration& e = field_.exploration;
  for (const int id : bins_[bin(q, 1) * kBins + bin(q, 0)]) {
    const Image& image = images_[id];
    if ((q.array() < image.lo.array()).any() || (q.array() > image.hi.array()).any()) continue;
    const Cell& cell = e.cells[id];
    const FieldPoint& center = e.samples[cell.center];
    std::size_t in_cell = 0;
    const auto take = [&](const FieldPoint& start) {
      // What the map's derivative says of a cell without a fold is right to a share of it.
      if (!image.folded && start.pull_back(q - start.q).norm() > kFurthestGuess * cell.radius)
        return;
      auto f = newton_to(q, start, cell.radius, evaluate);
      if (!f || !f->lit() || !(f->flux > 0.0)) return;
      if (field_.domain.worst(*f).value >
          kDomainRoundings * evaluate.map().rounding(f->x) * (1.0 + f->q_s.norm() + f->q_t.norm()))
        return;
      // Newton's method may end anywhere within rounding of the image, on one side of a fold.
      const double blur = 2.0 * kLocatorRoundings * evaluate.map().rounding(f->x);
      for (const FieldPoint& other : found) {
        const Vec3 apart = other.x - f->x;
        if (apart.norm() <= kOneRoot * cell.radius) return;
        const double stretch = std::sqrt(f->q_s.squaredNorm() + f->q_t.squaredNorm());
        if (other.a * f->a > 0.0 && f->push_forward(apart).norm() <= stretch * blur) return;
      }
      found.push_back(std::move(*f));
      ++in_cell;
    };
    if (center.arrives()) take(center);
    if (!image.folded && center.arrives()) continue;
    for (const Corner& corner : cell.polygon) {
      if (in_cell == kSheetsOfFold) break;
      // Neighbours share corners.
      if (std::find(tried.begin(), tried.end(), corner.sample) != tried.end()) continue;
      tried.push_back(corner.sample);
      take(e.samples[corner.sample]);
    }
  }
  return found;
}

}  // namespace caustic::solver
