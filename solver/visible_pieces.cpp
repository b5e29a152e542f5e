#include "solver/visible_pieces.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/corrector.h"

namespace caustic::solver {

namespace {

// Bisections of an interval that is not safe: both ends alike, ends different.
constexpr int kMaxScanDepth = 6;
constexpr int kMinScanDepth = 2;

struct Sighted {
  LightPath path;
  Sight sight;
  std::shared_ptr<const Hit[]> hits;
  bool hidden() const { return sight.hidden; }
  bool holds_at(const LightPath& to) const { return sight.used(path, to) < kUsableRoom; }
};

// Is all from the path `a`, for which `seen` holds, to b as they are? The rooms of both together
// reach from one to the other.
bool settled(const Sighted& seen, const LightPath& a, const Sighted& b) {
  if (seen.hidden() != b.hidden()) return false;
  const double before = seen.sight.used(seen.path, a);
  const double on_the_way = std::max(seen.sight.used(seen.path, b.path) - before, 0.0);
  const double back = b.sight.used(b.path, a);
  return (kUsableRoom - before) * back + kUsableRoom * on_the_way > on_the_way * back;
}

// A change of visibility between two vertices: the last point of the visible side.
struct Change {
  std::size_t segment;  // from this vertex
  Point x;
  std::shared_ptr<const Hit[]> hits;
  Ending ending;
  bool to_hidden;
};

class Scanner {
 public:
  Scanner(const Trace& trace, const Visibility& visibility, Evaluator& evaluate,
          const LevelFunction& level, double residual)
      : trace_(trace),
        visibility_(visibility),
        evaluate_(evaluate),
        level_(level),
        residual_(residual) {}

  struct Changes {
    bool hidden_first;
    std::vector<Change> all;  // in order
    std::size_t seen;         // so many segments, the last of them if time did not run out
  };
  Changes run() {
    const std::size_t n = trace_.vertices.size(), segments = trace_.closed ? n : n - 1;
    const Sighted first = look(0);
    Changes changes{first.hidden(), {}, segments};
    Sighted seen = first;     // the last that was looked at,
    std::size_t seen_at = 0;  // and where
    for (std::size_t i = 0; i < segments; ++i) {
      const std::size_t next = (i + 1) % n;
      if (seen.holds_at(path(next))) continue;
      if (evaluate_.budget().out_of_time()) {
        changes.seen = i;
        return changes;
      }
      const Sighted b = next == 0 ? first : look(next);
      if (!settled(seen, path(i), b)) {
        Sighted a = look(i);
        if (a.hidden() != seen.hidden()) change_between(seen, seen_at, a, i, changes.all);
        scan(i, a, b, 0, changes.all);
      }
      seen = b;
      seen_at = i + 1;
    }
    return changes;
  }

 private:
  Sighted look(const LightPath& path, std::shared_ptr<const Hit[]> hits) const {
    return {path, visibility_.look(evaluate_.map().hops(), path), std::move(hits)};
  }
  Sighted look(std::size_t i) const {
    return look(path(i), trace_.hits.empty() ? nullptr : trace_.hits[i]);
  }
  LightPath path(std::size_t i) const {
    const CurveVertex& v = trace_.vertices[i];
    return {evaluate_.map(), v.x, trace_.hits.empty() ? nullptr : trace_.hits[i].get(), v.p};
  }

  void scan(std::size_t segment, const Sighted& a, const Sighted& b, int depth,
            std::vector<Change>& out) {
    if (settled(a, a.path, b)) return;
    const bool alike = a.hidden() == b.hidden();
    if (depth >= (alike ? kMaxScanDepth : kMinScanDepth)) {
      if (!alike) out.push_back(locate(segment, a, b));
      return;
    }
    const auto middle = between(a, b);
    if (!middle) {
      if (!alike) out.push_back(locate(segment, a, b));
      return;
    }
    scan(segment, a, *middle, depth + 1, out);
    scan(segment, *middle, b, depth + 1, out);
  }

  // The room of a look is an estimate: where it reached too far, the vertex before the change is
  // found by bisection.
  void change_between(Sighted a, std::size_t at_a, Sighted b, std::size_t at_b,
                      std::vector<Change>& out) {
    while (at_b - at_a > 1) {
      const std::size_t middle = at_a + (at_b - at_a) / 2;
      Sighted m = look(middle);
      const bool with_a = m.hidden() == a.hidden();
      (with_a ? a : b) = std::move(m);
      (with_a ? at_a : at_b) = middle;
    }
    out.push_back(locate(at_a, a, b));
  }

  // A path from the share `w` of the way from a to b.
  std::optional<Sighted> between(const Sighted& a, const Sighted& b, double w = 0.5) {
    const Point &xa = a.path.x(), &xb = b.path.x();
    const auto f = correct(evaluate_, level_, xa + w * (xb - xa),
                           {residual_, geometry::kInfinity, (xb - xa).norm()}, a.hits.get());
    if (!f) return std::nullopt;
    return look(LightPath(evaluate_.map(), *f), f->hits);
  }

  // Bisection on the exact answer, down to rounding of x, of what the rooms of both sides leave.
  Change locate(std::size_t segment, Sighted a, Sighted b) {
    const bool to_hidden = b.hidden();
    const double rounding = evaluate_.map().rounding(a.path.x());
    for (int i = 0; i < 100 && (b.path.x() - a.path.x()).norm() > 2.0 * rounding; ++i) {
      const double from = kUsableRoom / a.sight.used(a.path, b.path);
      const double to = 1.0 - kUsableRoom / b.sight.used(b.path, a.path);
      const auto middle = between(a, b, from < to ? 0.5 * (from + to) : 0.5);
      if (!middle) break;
      (middle->hidden() == a.hidden() ? a : b) = *middle;
    }
    const Sighted& visible = to_hidden ? a : b;
    const Sighted& hidden = to_hidden ? b : a;
    return {segment, visible.path.x(), visible.hits, hidden.sight.ending, to_hidden};
  }

  const Trace& trace_;
  const Visibility& visibility_;
  Evaluator& evaluate_;
  const LevelFunction& level_;
  double residual_;
};

}  // namespace

std::vector<Trace> visible_pieces(Trace trace, const Visibility& visibility, Evaluator& evaluate,
                                  const LevelFunction& level, double residual) {
  const auto changes = Scanner(trace, visibility, evaluate, level, residual).run();
  std::vector<Trace> pieces;
  const auto open_piece = [&](Ending ending) {
    Trace piece;
    piece.conditioning = trace.conditioning;
    piece.ends = {ending};
    pieces.push_back(std::move(piece));
  };
  const auto keep_original_end = [&](Trace& piece) {
    piece.clipped |= trace.clipped;
    piece.stalled |= trace.stalled;
  };
  const std::size_t n = trace.vertices.size(), segments = trace.closed ? n : n - 1;
  bool open = !changes.hidden_first;
  if (open) {
    open_piece(trace.closed ? Ending::limit : trace.ends[0]);
    keep_original_end(pieces.back());
    pieces.back().vertices.push_back(trace.vertices[0]);
  }
  auto change = changes.all.begin();
  for (std::size_t i = 0; i < changes.seen; ++i) {
    for (; change != changes.all.end() && change->segment == i; ++change) {
      if (change->to_hidden == !open) continue;
      if (!change->to_hidden) open_piece(change->ending);
      pieces.back().vertices.push_back(
          make_vertex(evaluate.map(), level, evaluate(change->x, change->hits.get())));
      if (change->to_hidden) pieces.back().ends.push_back(change->ending);
      open = !change->to_hidden;
    }
    if (open && i + 1 < n) pieces.back().vertices.push_back(trace.vertices[i + 1]);
  }
  if (changes.seen < segments) {
    if (open) pieces.back().ends.push_back(Ending::limit);
    return pieces;
  }
  if (changes.all.empty()) {
    if (open) return {std::move(trace)};
    return {};
  }
  if (open && trace.closed) {
    // The last piece runs on through the start of the closed curve.
    Trace last = std::move(pieces.back());
    pieces.pop_back();
    if (pieces.empty()) return {std::move(trace)};
    Trace& head = pieces.front();
    head.vertices.insert(head.vertices.begin(), last.vertices.begin(), last.vertices.end());
    head.ends[0] = last.ends[0];
  } else if (open) {
    pieces.back().ends.push_back(trace.ends[1]);
    keep_original_end(pieces.back());
  }
  return pieces;
}

}  // namespace caustic::solver
