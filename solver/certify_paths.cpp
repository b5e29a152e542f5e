#include "solver/certify_paths.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/enclosed_path.h"

namespace caustic::solver {

using geometry::Interval;

namespace {

// A box is widened by this share before it is asked whether it holds one root, so that a root on
// the face between two boxes is inside of one of them.
constexpr double kInflate = 0.2;
// A contraction that leaves more than this share of the widest side is not worth another round.
constexpr double kWorthwhile = 0.7;
// Rounds of Krawczyk's operator on a proven box: it converges quadratically.
constexpr int kSharpen = 50;
// Proven boxes sharpened to this share of the scene hold the same root if they meet.
constexpr double kSameRoot = 1e-9;
// Sides are not cut in the middle: symmetric scenes have their roots there.
constexpr double kCut = 0.4873;

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, EnclosedPath::kMaxUnknowns,
                             EnclosedPath::kMaxUnknowns>;

// The inverse of the middles; nothing if there is none.
std::optional<Matrix> inverse_middle(const EnclosedPath::Rows& J, int size) {
  Matrix middle(size, size);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) middle(r, c) = J[r][c].middle();
  }
  if (!middle.allFinite()) return std::nullopt;
  Matrix Y = middle.inverse();
  if (!Y.allFinite()) return std::nullopt;
  return Y;
}

// One choice of sides for the surfaces that refract.
class Search {
 public:
  Search(EnclosedPath path, const PathBox& whole, double scale, const CertifyOptions& options,
         CertifiedRoots& result)
      : path_(std::move(path)), scale_(scale), options_(options), result_(result), stack_{whole} {}

  void run();

 private:
  enum class Verdict { empty, one, contracted, none };

  void treat(PathBox& box);
  Verdict krawczyk(const PathBox& widened, PathBox& box);
  Verdict cut_down(const PathBox& X, const PathMiddle& m, const Matrix& Y, PathBox& box) const;
  void accept(PathBox box);
  void divide(const PathBox& box);
  double widest(const PathBox& box, int& hop, int& axis) const;

  EnclosedPath path_;
  double scale_;
  const CertifyOptions& options_;
  CertifiedRoots& result_;
  std::vector<PathBox> stack_;
  std::vector<PathBox> proven_;
  // Of the box that the operator looks at.
  EnclosedPath::Values F_;
  EnclosedPath::Rows J_;
};

void Search::run() {
  while (!stack_.empty()) {
    const bool late =
        options_.budget && result_.boxes % kBetweenChecks == 0 && options_.budget->out_of_time();
    if (late || result_.boxes >= options_.max_boxes) {
      result_.undecided += stack_.size();
      return;
    }
    PathBox box = stack_.back();
    stack_.pop_back();
    ++result_.boxes;
    treat(box);
  }
}

double Search::widest(const PathBox& box, int& hop, int& axis) const {
  double width = -1.0;
  for (int i = 0; i < path_.hops(); ++i) {
    for (int a = 0; a < 3; ++a) {
      if (box.x[i][a].width() <= width) continue;
      width = box.x[i][a].width();
      hop = i;
      axis = a;
    }
  }
  return width;
}

// (S39): K = m − Y F(m) + (I − Y F′(X)) (X − m).
Search::Verdict Search::krawczyk(const PathBox& X, PathBox& box) {
  PathMiddle m;
  if (!path_.middle(X, m)) return Verdict::none;
  path_.values(m, F_);
  if (!path_.derivatives(X, m, J_)) return Verdict::none;
  const auto Y = inverse_middle(J_, 3 * path_.hops());
  return Y ? cut_down(X, m, *Y, box) : Verdict::none;
}

// To what the operator leaves of it.
Search::Verdict Search::cut_down(const PathBox& X, const PathMiddle& m, const Matrix& Y,
                                 PathBox& box) const {
  const int size = static_cast<int>(Y.rows());
  bool inside = true, empty = false;
  for (int r = 0; r < size; ++r) {
    const int hop = r / 3, axis = r % 3;
    Interval K(m.x[hop][axis]);
    for (int c = 0; c < size; ++c) K -= Y(r, c) * F_[c];
    for (int c = 0; c < size; ++c) {
      Interval slope(r == c ? 1.0 : 0.0);
      for (int k = 0; k < size; ++k) slope -= Y(r, k) * J_[k][c];
      K += slope * (X.x[c / 3][c % 3] - m.x[c / 3][c % 3]);
    }
    const Interval& wide = X.x[hop][axis];
    inside &= K.lo > wide.lo && K.hi < wide.hi;
    const Interval cut = geometry::intersection(box.x[hop][axis], K);
    box.x[hop][axis] = cut.empty() ? geometry::intersection(wide, K) : cut;
    empty |= cut.empty();
  }
  // Inside: there is exactly one root in X, be it in the box or beside it.
  return inside ? Verdict::one : empty ? Verdict::empty : Verdict::contracted;
}

void Search::treat(PathBox& box) {
  for (;;) {
    if (path_.impossible(box)) return;
    for (const PathBox& known : proven_) {
      bool within = true;
      for (int i = 0; i < path_.hops() && within; ++i) {
        for (int a = 0; a < 3; ++a) within &= known.x[i][a].contains(box.x[i][a]);
      }
      if (within) return;
    }
    if (!path_.promising(box)) return divide(box);
    int hop = 0, axis = 0;
    const double before = widest(box, hop, axis);
    PathBox wide = box;
    for (int i = 0; i < path_.hops(); ++i) {
      for (int a = 0; a < 3; ++a) {
        const double margin = kInflate * before;
        wide.x[i][a] = {box.x[i][a].lo - margin, box.x[i][a].hi + margin};
      }
    }
    PathBox contracted = box;
    const Verdict verdict = krawczyk(wide, contracted);
    if (verdict == Verdict::empty) return;
    if (verdict == Verdict::one) {
      proven_.push_back(wide);
      return accept(wide);
    }
    if (verdict == Verdict::contracted) box = contracted;
    const double after = widest(box, hop, axis);
    if (after > kWorthwhile * before) return divide(box);
  }
}

// Sharpens a proven box to a point, and keeps it if the optics obeys and it is new.
void Search::accept(PathBox box) {
  for (int k = 0; k < kSharpen; ++k) {
    PathBox next = box;
    const Verdict verdict = krawczyk(box, next);
    int hop = 0, axis = 0;
    const double before = widest(box, hop, axis), after = widest(next, hop, axis);
    if (verdict == Verdict::empty || verdict == Verdict::none) break;
    box = next;
    if (!(after < before)) break;
  }
  if (path_.impossible(box)) return;
  int hop = 0, axis = 0;
  // Not sharp enough to tell it from another.
  result_.undecided += widest(box, hop, axis) > kSameRoot * scale_;
  std::vector<Point> root(path_.hops());
  for (int i = 0; i < path_.hops(); ++i) {
    for (int a = 0; a < 3; ++a) root[i][a] = box.x[i][a].middle();
  }
  for (const auto& other : result_.roots) {
    double distance = 0.0;
    for (int i = 0; i < path_.hops(); ++i)
      distance = std::max(distance, (other[i] - root[i]).norm());
    if (distance <= kSameRoot * scale_) return;
  }
  result_.roots.push_back(std::move(root));
}

void Search::divide(const PathBox& box) {
  int hop = 0, axis = 0;
  const double width = widest(box, hop, axis);
  if (!(width > options_.smallest * scale_)) {
    result_.undecided += !path_.holds_only_a_point(box);
    return;
  }
  const Interval& side = box.x[hop][axis];
  const double cut = side.lo + kCut * side.width();
  PathBox lower = box, upper = box;
  lower.x[hop][axis].hi = cut;
  upper.x[hop][axis].lo = cut;
  stack_.push_back(lower);
  stack_.push_back(upper);
}

}  // namespace

CertifiedRoots certify_paths(const std::vector<PathSurface>& surfaces,
                             const std::vector<geometry::Box>& regions, const Light& light,
                             const Point& to, double scale, const CertifyOptions& options) {
  CertifiedRoots result;
  PathBox whole;
  for (std::size_t i = 0; i < surfaces.size(); ++i) whole.x[i] = geometry::intervals(regions[i]);
  // Light may come to a refracting surface from either side; what it obeys then differs.
  std::vector<int> refracting;
  for (int i = 0; i < static_cast<int>(surfaces.size()); ++i) {
    if (!surfaces[i].reflects) refracting.push_back(i);
  }
  for (int choice = 0; choice < 1 << refracting.size(); ++choice) {
    std::vector<int> sides(surfaces.size(), 0);
    for (std::size_t k = 0; k < refracting.size(); ++k) {
      sides[refracting[k]] = choice >> k & 1 ? -1 : 1;
    }
    Search(EnclosedPath(surfaces, light, to, scale, sides), whole, scale, options, result).run();
  }
  return result;
}

}  // namespace caustic::solver
