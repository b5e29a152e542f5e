#include "solver/certify_contours.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

#include "geometry/root_finding.h"

namespace caustic::solver {

using geometry::GraphChart;

namespace {

// An edge along which a level function may have several roots is halved so often; then its cell is.
constexpr int kEdgeHalvings = 12;
// A root on an edge is located to this share of the values at the ends of its bracket.
constexpr double kEdgeRoot = 1e-10;
// Seeds up to so many roundings outside the domain lie on its boundary.
constexpr double kOnBoundary = 1e3;

class Certifier {
 public:
  Certifier(Evaluator& evaluate, const Domain& domain, const std::vector<LevelFunction>& targets,
            const ContourCertificateOptions& options)
      : evaluate_(evaluate),
        domain_(domain),
        targets_(targets),
        options_(options),
        map_(evaluate.map()),
        smallest_(options.smallest * evaluate.map().system().diameter()) {
    for (int i = 0; i < domain.first_later(); ++i) like_.push_back(domain.first_like(i));
    like_.insert(like_.end(), 2, domain.first_later());  // the ends of charts
  }

  ContourCertificate run();

 private:
  struct Square {
    int chart;
    GraphCell cell;
    std::vector<int> open;  // targets not settled there
  };

  void treat(Square square);
  void divide(const Square& square);
  void give_up(const Square& square);
  bool nothing_there(const GraphChart& chart, GraphCell& cell);
  Slopes enclosed(const EnclosedField& field, int target) const;
  bool settled(const Slopes& F, int boundary) const;
  std::vector<int> find_edge_roots(const GraphChart& chart, const GraphCell& cell,
                                   const std::vector<int>& targets);
  void search(const GraphChart& chart, GraphCell edge, const std::vector<int>& targets,
              int halvings, std::vector<int>& left);
  std::vector<int> signs_at(const GraphChart& chart, const GraphCell& edge, bool end,
                            const std::vector<int>& targets);
  void add_seed(const GraphChart& chart, const GraphCell& edge, int target);
  Point point(const GraphChart& chart, const GraphCell& cell, double s, double t) const;

  Evaluator& evaluate_;
  const Domain& domain_;
  const std::vector<LevelFunction>& targets_;
  const ContourCertificateOptions& options_;
  EnclosedMap map_;
  std::vector<int> like_;  // of each bound the first that is the same
  double smallest_;
  std::vector<GraphChart> charts_;
  std::deque<Square> queue_;
  EnclosedField field_, on_edge_;
  double reach_ = 0.0;
  ContourCertificate result_;
};

// The point of the graph over (s, t), to rounding; where it is not in the cell, one next to it.
Point Certifier::point(const GraphChart& chart, const GraphCell& cell, double s, double t) const {
  Point x;
  x[chart.first()] = s;
  x[chart.second()] = t;
  x[chart.along()] = cell.z.middle();
  Vec3 gradient;
  for (int i = 0; i < 8; ++i) {
    const double g = map_.map().shape().value_gradient(x, gradient);
    const double step = g / gradient[chart.along()];
    if (!std::isfinite(step)) break;
    x[chart.along()] -= step;
    if (std::abs(step) <= map_.map().rounding(x)) break;
  }
  x[chart.along()] = std::clamp(x[chart.along()], cell.z.lo, cell.z.hi);
  return x;
}

// True if no light comes from the cell or none of it is inside of the domain and the chart.
bool Certifier::nothing_there(const GraphChart& chart, GraphCell& cell) {
  if (!map_.narrow(chart, cell)) return true;
  map_.enclose(chart, cell, field_);
  return field_.dark || std::any_of(field_.bounds.begin(), field_.bounds.end(),
                                    [](const Slopes& h) { return h.v.lo > 0.0; });
}

Slopes Certifier::enclosed(const EnclosedField& field, int target) const {
  const LevelFunction& level = targets_[target];
  return level.is_boundary() ? field.bounds[level.boundary] : field.level(level.k);
}

// (S73), (S74): F = 0 is a graph over one of the coordinates, and along it all the other boundaries
// that pass through the cell fall or all of them rise.
bool Certifier::settled(const Slopes& F, int boundary) const {
  if (F.s.contains_zero() && F.t.contains_zero()) return false;
  const int like = boundary < 0 ? -1 : like_[boundary];
  int way = 0;
  for (int i = 0; i < static_cast<int>(field_.bounds.size()); ++i) {
    const Slopes& h = field_.bounds[i];
    if (h.v.hi < 0.0 || like_[i] == like) continue;
    const int sign = sign_of(F.s * h.t - F.t * h.s);
    if (sign == 0 || sign == -way) return false;
    way = sign;
  }
  return true;
}

// Of each target at one end of an edge.
std::vector<int> Certifier::signs_at(const GraphChart& chart, const GraphCell& edge, bool end,
                                     const std::vector<int>& targets) {
  GraphCell corner{end ? edge.s.hi : edge.s.lo, end ? edge.t.hi : edge.t.lo, edge.z, true};
  map_.narrow(chart, corner);
  map_.enclose(chart, corner, on_edge_);
  std::vector<int> signs;
  for (const int target : targets) signs.push_back(sign_of(enclosed(on_edge_, target).v));
  return signs;
}

// (S75): all roots on an edge, which is an interval in one coordinate and a number in the other.
// `left` are targets that may have more than was found.
void Certifier::search(const GraphChart& chart, GraphCell edge, const std::vector<int>& targets,
                       int halvings, std::vector<int>& left) {
  if (!map_.narrow(chart, edge)) return;
  map_.enclose(chart, edge, on_edge_);
  if (on_edge_.dark) return;
  for (const Slopes& h : on_edge_.bounds) {
    if (h.v.lo > 0.0) return;
  }
  if (!on_edge_.regular) halvings = 0;
  const bool upright = edge.s.width() == 0.0;
  std::vector<int> monotone, others;
  for (const int target : targets) {
    const Slopes F = enclosed(on_edge_, target);
    if (!F.v.contains_zero()) continue;
    ((upright ? F.t : F.s).contains_zero() ? others : monotone).push_back(target);
  }
  if (!monotone.empty()) {
    const auto from = signs_at(chart, edge, false, monotone);
    const auto to = signs_at(chart, edge, true, monotone);
    for (std::size_t i = 0; i < monotone.size(); ++i) {
      if (from[i] * to[i] <= 0) add_seed(chart, edge, monotone[i]);
    }
  }
  if (others.empty()) return;
  if (halvings == 0) {
    left.insert(left.end(), others.begin(), others.end());
    return;
  }
  GraphCell low = edge, high = edge;
  Interval &first = upright ? low.t : low.s, &second = upright ? high.t : high.s;
  first.hi = second.lo = first.middle();
  search(chart, low, others, halvings - 1, left);
  search(chart, high, others, halvings - 1, left);
}

// The root on an edge along which F is monotone and changes its sign, or touches zero.
void Certifier::add_seed(const GraphChart& chart, const GraphCell& edge, int target) {
  const LevelFunction& level = targets_[target];
  FieldPoint at;
  const auto value = [&](double w) {
    at = evaluate_(
        point(chart, edge, edge.s.lo + w * edge.s.width(), edge.t.lo + w * edge.t.width()));
    return at.finite ? level.value(at) : 0.0;
  };
  const double from = value(0.0);
  const FieldPoint first = at;
  const double to = value(1.0), small = kEdgeRoot * std::max(std::abs(from), std::abs(to));
  if (from * to < 0.0) {
    geometry::illinois_root(
        value, [&](double, double v) { return std::abs(v) <= small; }, 0.0, 1.0, from, to);
  } else if (std::abs(from) < std::abs(to)) {
    at = first;
  }
  const double slack = kOnBoundary * map_.map().rounding(at.x);
  if (!at.arrives()) return;
  const Domain& domain = level.is_boundary() ? domain_.without(level.boundary) : domain_;
  if (domain.worst(at).value > slack) return;
  result_.seeds.push_back({target, at, reach_});
}

// Roots on the lower edges, and on the upper ones where no other cell of the chart has them as its
// lower ones. Returns the targets of which not all were found.
std::vector<int> Certifier::find_edge_roots(const GraphChart& chart, const GraphCell& cell,
                                            const std::vector<int>& targets) {
  reach_ = std::hypot(cell.s.width(), cell.t.width());
  std::vector<GraphCell> edges(2, cell);
  edges[0].s = cell.s.lo;
  edges[1].t = cell.t.lo;
  if (cell.s.hi == chart.own[chart.first()].hi) {
    edges.push_back(cell);
    edges.back().s = cell.s.hi;
  }
  if (cell.t.hi == chart.own[chart.second()].hi) {
    edges.push_back(cell);
    edges.back().t = cell.t.hi;
  }
  std::vector<int> left;
  for (const GraphCell& edge : edges) search(chart, edge, targets, kEdgeHalvings, left);
  std::sort(left.begin(), left.end());
  left.erase(std::unique(left.begin(), left.end()), left.end());
  return left;
}

void Certifier::treat(Square square) {
  const GraphChart& chart = charts_[square.chart];
  if (nothing_there(chart, square.cell)) return;
  if (square.cell.whole && field_.regular) {
    std::vector<int> done;
    std::erase_if(square.open, [&](int target) {
      const Slopes F = enclosed(field_, target);
      if (!F.v.contains_zero()) return true;
      if (!settled(F, targets_[target].boundary)) return false;
      done.push_back(target);
      return true;
    });
    if (!done.empty()) done = find_edge_roots(chart, square.cell, done);
    square.open.insert(square.open.end(), done.begin(), done.end());
    if (square.open.empty()) return;
  }
  if (std::max(square.cell.s.width(), square.cell.t.width()) <= smallest_) return give_up(square);
  divide(square);
}

void Certifier::divide(const Square& square) {
  Square low = square, high = square;
  const GraphCell& cell = square.cell;
  if (cell.s.width() >= cell.t.width()) {
    low.cell.s.hi = high.cell.s.lo = cell.s.middle();
  } else {
    low.cell.t.hi = high.cell.t.lo = cell.t.middle();
  }
  queue_.push_back(std::move(low));
  queue_.push_back(std::move(high));
}

void Certifier::give_up(const Square& square) {
  const GraphChart& chart = charts_[square.chart];
  const GraphCell& cell = square.cell;
  UndecidedCell undecided{
      {point(chart, cell, cell.s.lo, cell.t.lo), point(chart, cell, cell.s.hi, cell.t.lo),
       point(chart, cell, cell.s.hi, cell.t.hi), point(chart, cell, cell.s.lo, cell.t.hi)},
      square.open};
  result_.undecided.push_back(std::move(undecided));
}

ContourCertificate Certifier::run() {
  const auto& mirror = map_.map().mirror();
  auto cover = geometry::cover_by_graphs(*mirror.shape, mirror.bounds, mirror.region,
                                         [&] { return evaluate_.budget().exhausted(); });
  result_.exhausted = evaluate_.budget().exhausted();
  charts_ = std::move(cover.charts);
  std::vector<int> all(targets_.size());
  std::iota(all.begin(), all.end(), 0);
  for (const geometry::Box& box : cover.undecided) {
    result_.undecided.push_back({{box.min, box.min, box.max, box.max}, all});
  }
  for (int i = 0; i < static_cast<int>(charts_.size()); ++i) {
    const GraphChart& chart = charts_[i];
    queue_.push_back(
        {i, {chart.own[chart.first()], chart.own[chart.second()], chart.reach, false}, all});
  }
  while (!queue_.empty()) {
    if (result_.cells >= options_.max_cells || evaluate_.budget().exhausted()) {
      result_.exhausted = true;
      if (evaluate_.budget().cancelled()) break;
      for (const Square& square : queue_) give_up(square);
      break;
    }
    Square next = std::move(queue_.front());
    queue_.pop_front();
    ++result_.cells;
    treat(std::move(next));
  }
  return std::move(result_);
}

}  // namespace

ContourCertificate certify_contours(Evaluator& evaluate, const Domain& domain,
                                    const std::vector<LevelFunction>& targets,
                                    const ContourCertificateOptions& options) {
  return Certifier(evaluate, domain, targets, options).run();
}

}  // namespace caustic::solver
