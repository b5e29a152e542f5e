// A labelled isolux diagram: axes in the user's length unit, a colour for each level, the level
// written on its curves, caustics dashed, a legend.
#include <algorithm>
#include <cmath>
#include <set>

#include "service/formats/format.h"
#include "service/formats/svg_labels.h"
#include "service/formats/svg_plot.h"

namespace caustic::service {
namespace {

constexpr double kFontSize = 12;
constexpr int kMostLegendRows = 24;
constexpr const char* kCausticColor = "#b3261e";
constexpr const char* kBoundaryColor = "#777777";

constexpr const char* kStyle =
    "<style>text{font-family:'DejaVu Sans',Verdana,Helvetica,sans-serif;font-size:12px;fill:#222}"
    ".title{font-size:16px;font-weight:bold}.small{font-size:11px;fill:#666}"
    ".grid{stroke:#e6e8eb;stroke-width:1}.tick{stroke:#444;stroke-width:1}"
    ".frame{fill:none;stroke:#444;stroke-width:1.2}"
    ".curve{fill:none;stroke-width:1.7;stroke-linejoin:round;stroke-linecap:round}"
    ".caustic{stroke-dasharray:7 "
    "4;stroke-linecap:butt}.jump{stroke-width:0.8}.boundary{stroke-width:0.6;stroke-dasharray:2 3}"
    ".label{font-size:11px;text-anchor:middle;paint-order:stroke;stroke:#fff;stroke-width:4px;"
    "stroke-linejoin:round}</style>\n";

std::string element(const char* name,
                    std::initializer_list<std::pair<const char*, std::string>> attributes) {
  std::string out(1, '<');
  out += name;
  for (const auto& [key, value] : attributes)
    out.append(" ").append(key).append("=\"").append(value).append("\"");
  return out;
}

std::string line(const char* style, const Pixel& a, const Pixel& b) {
  return element("line", {{"class", style},
                          {"x1", pixel_text(a.x)},
                          {"y1", pixel_text(a.y)},
                          {"x2", pixel_text(b.x)},
                          {"y2", pixel_text(b.y)}}) +
         "/>\n";
}

std::string text(const Pixel& at, const char* anchor, const std::string& what,
                 const char* style = "", double degrees = 0.0) {
  const std::string x = pixel_text(at.x), y = pixel_text(at.y);
  std::string out = element("text", {{"x", x}, {"y", y}, {"text-anchor", anchor}});
  if (*style) out.append(" class=\"").append(style).append("\"");
  if (degrees != 0.0)
    out.append(" transform=\"rotate(")
        .append(pixel_text(degrees) + ' ' + x + ' ' + y)
        .append(")\"");
  return out.append(">").append(what).append("</text>\n");
}

/// W/m2 as it is printed.
std::string printed_unit(const PolylineSet& set) {
  return set.irradiance_unit == "W/m2" ? "W/m²" : set.irradiance_unit;
}

std::vector<double> levels_of(const PolylineSet& set) {
  std::set<double> levels;
  for (const Polyline& curve : set.curves)
    if (curve.has_level()) levels.insert(curve.level);
  return {levels.begin(), levels.end()};
}

const char* style_of(const Polyline& curve) {
  if (curve.is_boundary()) return "curve boundary";
  return curve.is_caustic() ? "curve caustic" : curve.is_jump() ? "curve jump" : "curve";
}

std::string color_of(const Polyline& curve, const std::vector<double>& levels) {
  if (curve.is_caustic()) return kCausticColor;
  if (curve.is_boundary()) return kBoundaryColor;
  const double low = std::log(levels.front()), high = std::log(levels.back());
  return level_color(high > low ? (std::log(curve.level) - low) / (high - low) : 0.3);
}

std::string axes(const PolylineSet& set, const SvgPlot& plot) {
  const double left = SvgPlot::kLeft, bottom = SvgPlot::kTop + plot.height();
  std::string grid, marks;
  for (double u : ticks(0.5 * set.receiver_size[0])) {
    const double x = plot.pixel({u, 0}).x;
    grid += line("grid", {x, SvgPlot::kTop}, {x, bottom});
    marks += line("tick", {x, bottom}, {x, bottom + 5}) +
             text({x, bottom + 19}, "middle", label_text(u));
  }
  for (double v : ticks(0.5 * set.receiver_size[1])) {
    const double y = plot.pixel({0, v}).y;
    grid += line("grid", {left, y}, {left + plot.width(), y});
    marks += line("tick", {left - 5, y}, {left, y}) + text({left - 9, y + 4}, "end", label_text(v));
  }
  const Pixel below{left + 0.5 * plot.width(), bottom + 44},
      beside{34, SvgPlot::kTop + 0.5 * plot.height()};
  return grid + marks + text(below, "middle", "u [" + set.length_unit + "]") +
         text(beside, "middle", "v [" + set.length_unit + "]", "", -90);
}

std::vector<Pixel> pixels_of(const PolylineSet& set, const Polyline& curve, const SvgPlot& plot) {
  std::vector<Pixel> out;
  for (std::uint64_t i = 0; i < curve.file_vertices(); ++i)
    out.push_back(plot.pixel(set.vertex(curve, i).uv));
  return out;
}

std::string path(const Polyline& curve, std::size_t id, const std::vector<Pixel>& pixels,
                 const std::string& color) {
  std::string out = element(
      "path",
      {{"id", "curve" + std::to_string(id)}, {"class", style_of(curve)}, {"stroke", color}});
  out += " d=\"";
  std::string last;
  for (const Pixel& p : pixels) {
    const std::string here = pixel_text(p.x) + ' ' + pixel_text(p.y);
    if (here != last) out.append(last.empty() ? "M" : "L").append(here);
    last = here;
  }
  if (curve.closed) out += 'Z';
  return out += "\"/>\n";
}

std::string curves(const PolylineSet& set, const SvgPlot& plot, const std::vector<double>& levels) {
  SvgLabelPlacer placer(plot);
  std::string paths, labels;
  for (std::size_t id = 0; id < set.curves.size(); ++id) {
    const Polyline& curve = set.curves[id];
    const std::vector<Pixel> pixels = pixels_of(set, curve, plot);
    paths += path(curve, id, pixels, color_of(curve, levels));
    if (!curve.has_level() || curve.is_jump()) continue;
    const std::string what = label_text(curve.level);
    for (const SvgLabel& label :
         placer.place(pixels, 0.62 * kFontSize * static_cast<double>(what.size())))
      labels += text({label.at.x, label.at.y + 4}, "middle", what, "label", label.degrees);
  }
  return "<g clip-path=\"url(#receiver)\">\n" + paths + "</g>\n" + labels;
}

/// Brightest on top; of very many levels an even choice.
std::string legend(const PolylineSet& set, const SvgPlot& plot, const std::vector<double>& levels) {
  const double x = SvgPlot::kLeft + plot.width() + 22;
  double y = SvgPlot::kTop + 10;
  std::string out = text({x, y}, "start", set.quantity + " [" + printed_unit(set) + "]");
  const auto row = [&](const Polyline& curve, const std::string& what) {
    y += 22;
    out += element("line", {{"class", style_of(curve)},
                            {"stroke", color_of(curve, levels)},
                            {"x1", pixel_text(x)},
                            {"y1", pixel_text(y - 4)},
                            {"x2", pixel_text(x + 30)},
                            {"y2", pixel_text(y - 4)}}) +
           "/>\n";
    out += text({x + 40, y}, "start", what);
  };
  const std::size_t stride = (levels.size() + kMostLegendRows - 1) / kMostLegendRows;
  for (std::size_t i = levels.size(); i-- > 0;)
    if ((levels.size() - 1 - i) % stride == 0)
      row({.kind = PolylineKind::isolux, .level = levels[i]}, label_text(levels[i]));
  const bool any_caustic = std::any_of(set.curves.begin(), set.curves.end(),
                                       [](const Polyline& c) { return c.is_caustic(); });
  if (any_caustic) row({.kind = PolylineKind::caustic, .level = -1.0}, "caustic");
  if (set.curves.empty()) out += text({x, y + 22}, "start", "no curves", "small");
  return out;
}

std::string rectangle(const SvgPlot& plot, const char* attributes) {
  return element("rect", {{"x", pixel_text(SvgPlot::kLeft)},
                          {"y", pixel_text(SvgPlot::kTop)},
                          {"width", pixel_text(plot.width())},
                          {"height", pixel_text(plot.height())}}) +
         attributes + "/>\n";
}

}  // namespace

std::string write_svg(const PolylineSet& set) {
  const SvgPlot plot(set.receiver_size);
  const std::vector<double> levels = levels_of(set);
  const int rows = std::min(static_cast<int>(levels.size()), kMostLegendRows) + 1;
  const std::string width = pixel_text(plot.page_width()),
                    height = pixel_text(plot.page_height(rows));
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
         "\" viewBox=\"0 0 " + width + ' ' + height + "\">\n<title>Isolux diagram</title>\n" +
         kStyle + "<defs><clipPath id=\"receiver\">" + rectangle(plot, "") +
         "</clipPath></defs>\n" + "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" +
         text({SvgPlot::kLeft, 32}, "start",
              "Isolux curves on the receiver, " + set.quantity + " in " + printed_unit(set),
              "title") +
         axes(set, plot) + curves(set, plot, levels) + legend(set, plot, levels) +
         rectangle(plot, " class=\"frame\"") + "</svg>\n";
}

}  // namespace caustic::service
