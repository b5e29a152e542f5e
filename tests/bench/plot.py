#!/usr/bin/env python3
"""Draws tables as panels of curves: plot.py SPEC.json OUT.svg

The specification names its tables, relative to itself; numbers stand in them only:

  {"title": "...", "columns": 2, "panels": [{
     "title": "...", "x": "label", "y": "label", "log": "xy",       the last two may be left out
     "csv": "table.csv", "where": {"column": "value"},              which rows; all, if left out
     "data": ["x column", "y column"], "series": "column",          a curve for each value of it
     "order": ["name", ...], "names": {"name": "in the legend"},
     "legend": false,                                               if a panel before it has it
     "fits": {"name": {"expected": 1, "from": 16, "to": 64}}}]}     slope on logs, and a dashed line of what was expected

Lines of a table that begin with # are remarks. A series has the same colour and mark in all panels.
Slopes found are printed, and stand in the legend.
"""

import csv
import json
import math
import pathlib
import sys
from html import escape

# Okabe and Ito's colours, which people who see red and green alike can tell apart, somewhat
# darker on white and lighter on black; marks differ too.
LIGHT = ["#0072b2", "#d55e00", "#007a5a", "#b3498a", "#a87400", "#3d94cc", "#555555", "#7a3fb0"]
DARK = ["#56b4e9", "#ff8c42", "#2fc79c", "#e79ac6", "#f0c040", "#9fd3ff", "#bbbbbb", "#c4a1f0"]
MARKS = ["M-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z", "M-2.7-2.7h5.4v5.4h-5.4z", "M0-3.8L3.5 2.4h-7z",
         "M0-4L3.6 0 0 4-3.6 0z", "M0 3.8L3.5-2.4h-7z", "M-3-3L3 3M-3 3L3-3", "M-3.6 0h7.2M0-3.6v7.2",
         "M-3.6-1.5h7.2v3h-7.2z"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM, ROW, TITLE = 400, 250, 62, 16, 30, 40, 16, 34
STYLE = """
  svg { --ink: #24292f; --faint: #d0d7de; --paper: #fff; %s }
  @media (prefers-color-scheme: dark) { svg { --ink: #e6edf3; --faint: #3d444d; --paper: #0d1117; %s } }
  .paper { fill: var(--paper) } text { fill: var(--ink); font: 11px system-ui, sans-serif }
  .title { font-weight: 600; font-size: 13px } .grid { stroke: var(--faint); stroke-width: 1; fill: none }
  .curve { fill: none; stroke-width: 1.8; stroke-linejoin: round } .mark { stroke-width: 1.4 }
  .expected { fill: none; stroke-width: 1.2; stroke-dasharray: 2 4; stroke-linecap: round }
""" % tuple("".join(f"--c{i}: {c}; " for i, c in enumerate(colours)) for colours in (LIGHT, DARK))


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def series_of(panel, folder):
    """The panel's curves: name → points in order of x; what is missing or cannot be drawn is left out."""
    x, y = panel["data"]
    log = panel.get("log", "xy")
    found = {name: [] for name in panel.get("order", [])}
    for row in rows_of(folder / panel["csv"]):
        if any(row[column] != value for column, value in panel.get("where", {}).items()):
            continue
        if not row[x] or not row[y]:
            continue
        point = float(row[x]), float(row[y])
        if all(math.isfinite(v) and (v > 0 or axis not in log) for axis, v in zip("xy", point)):
            found.setdefault(row[panel["series"]], []).append(point)
    return {name: sorted(points) for name, points in found.items() if points}


def slope(points):
    """Of the straight line of least squares through the logarithms, and the point it goes through."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    mx, my = (sum(column) / len(logs) for column in zip(*logs))
    across = sum((x - mx) ** 2 for x, _ in logs)
    return sum((x - mx) * (y - my) for x, y in logs) / across, (math.exp(mx), math.exp(my))


class Axis:
    """Values onto pixels, logarithmic or not, with a little room at both ends."""

    def __init__(self, values, log, begin, end):
        self.log, self.begin, self.end = log, begin, end
        low, high = (self.on(f(values)) for f in (min, max))
        room = 0.06 * (high - low) or 0.5
        self.low, self.high = low - room, high + room
        if not log and low >= 0:
            self.low = 0.0

    def on(self, value):
        return math.log10(value) if self.log else value

    def __call__(self, value):
        return self.begin + (self.on(value) - self.low) / (self.high - self.low) * (self.end - self.begin)

    def ticks(self, wanted=6):
        if self.log:
            decades = range(math.ceil(self.low), math.floor(self.high) + 1)
            if len(decades) > 2:
                return [10.0**k for k in decades[:: math.ceil(len(decades) / (wanted + 2))]]
            steps = [1, 2, 5] if self.high - self.low > 0.7 else [1, 1.5, 2, 3, 4, 5, 6, 8]
            all_decades = range(math.floor(self.low), math.ceil(self.high) + 1)
            ticks = [m * 10.0**k for k in all_decades for m in steps]
            return [t for t in ticks if self.low <= math.log10(t) <= self.high]
        step = 10.0 ** math.floor(math.log10((self.high - self.low) / wanted))
        step *= next((m for m in (1, 2, 5) if (self.high - self.low) / (m * step) <= wanted), 10)
        return [i * step for i in range(math.ceil(self.low / step), math.floor(self.high / step) + 1)]


def label(value):
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:,.6g}"
    mantissa, exponent = f"{value:.0e}".split("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return ("" if mantissa == "1" else mantissa + "·") + "10" + power


def text(x, y, content, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{escape(content)}</text>'


def draw_grid(panel, x, y):
    yield f'<rect class="grid" x="{LEFT}" y="{TOP}" width="{x.end - x.begin}" height="{y.begin - y.end}"/>'
    for tick in x.ticks():
        yield f'<path class="grid" d="M{x(tick):.1f} {y.begin}V{y.end}"/>'
        yield text(x(tick), y.begin + 14, label(tick))
    for tick in y.ticks():
        yield f'<path class="grid" d="M{x.begin} {y(tick):.1f}H{x.end}"/>'
        yield text(x.begin - 5, y(tick) + 4, label(tick), "end")
    middle = (y.begin + y.end) / 2
    yield text((x.begin + x.end) / 2, y.begin + 29, panel["x"])
    yield text(12, middle, panel["y"], more=f' transform="rotate(-90 12 {middle})"')
    yield text(LEFT, TOP - 9, panel["title"], "start", ' class="title"')


def fit_of(panel, name, points):
    """What the panel asks about the curve: slope found, slope expected, and the line of it."""
    fit = panel.get("fits", {}).get(name)
    chosen = [p for p in points if fit and fit.get("from", 0) <= p[0] <= fit.get("to", math.inf)]
    if len(chosen) < 2:
        return None
    found, (mx, my) = slope(chosen)
    line = [(x, my * (x / mx) ** fit["expected"]) for x in (chosen[0][0], chosen[-1][0])]
    print(f"{panel['title']} | {name} | expected {fit['expected']:g} | found {found:.2f}")
    return f": slope {found:.2f}, expected {fit['expected']:g}", line


def has_legend(panel):
    return panel.get("legend", True)


def draw_panel(panel, series, kinds):
    fits = {name: fit_of(panel, name, points) for name, points in series.items()}
    everything = [p for points in series.values() for p in points]
    log = panel.get("log", "xy")
    x = Axis([p[0] for p in everything], "x" in log, LEFT, WIDTH - RIGHT)
    y = Axis([p[1] for p in everything], "y" in log, TOP + HEIGHT - BOTTOM, TOP)
    yield from draw_grid(panel, x, y)
    way = lambda points: "M" + "L".join(f"{x(a):.1f} {y(b):.1f}" for a, b in points)
    for row, (name, points) in enumerate(series.items()):
        kind = kinds[name]
        colour = f"var(--c{kind % len(LIGHT)})"
        hollow = kind // len(LIGHT) % 2 == 1
        mark = f'class="mark" d="{MARKS[kind % len(MARKS)]}" stroke="{colour}" fill="{"none" if hollow else colour}"'
        at = TOP + HEIGHT + ROW * row + 8
        if fits[name]:
            yield f'<path class="expected" d="{way(fits[name][1])}" stroke="{colour}"/>'
        yield f'<path class="curve" d="{way(points)}" stroke="{colour}"/>'
        places = [(x(a), y(b)) for a, b in points] + [(LEFT + 11, at)] * has_legend(panel)
        for px, py in places:
            yield f'<path {mark} transform="translate({px:.1f} {py:.1f})"/>'
        if not has_legend(panel):
            continue
        yield f'<path class="curve" d="M{LEFT} {at}h22" stroke="{colour}"/>'
        yield text(LEFT + 29, at + 4, panel.get("names", {}).get(name, name) + (fits[name] or ("",))[0], "start")


def draw(spec, folder):
    panels = [(panel, series_of(panel, folder)) for panel in spec["panels"]]
    for panel, series in panels:
        if not series:
            raise SystemExit(f"plot.py: nothing to draw in \"{panel['title']}\"")
    names = dict.fromkeys(name for _, series in panels for name in series)
    kinds = {name: kind for kind, name in enumerate(names)}
    columns = min(spec.get("columns", 2), len(panels))
    parts, down = [], TITLE if "title" in spec else 8
    if "title" in spec:
        parts.append(text(LEFT, 20, spec["title"], "start", ' class="title"'))
    for first in range(0, len(panels), columns):
        line = panels[first : first + columns]
        for i, (panel, series) in enumerate(line):
            body = "\n".join(draw_panel(panel, series, kinds))
            parts.append(f'<g transform="translate({i * WIDTH} {down})">\n{body}\n</g>')
        down += TOP + HEIGHT + ROW * max(len(series) * has_legend(panel) for panel, series in line) + 12
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns * WIDTH} {down}" '
            f'width="{columns * WIDTH}" height="{down}">\n<style>{STYLE}</style>\n'
            f'<rect class="paper" width="100%" height="100%"/>\n' + "\n".join(parts) + "\n</svg>\n")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit("usage: plot.py SPEC.json OUT.svg")
    spec_path = pathlib.Path(sys.argv[1])
    svg = draw(json.loads(spec_path.read_text()), spec_path.parent)
    pathlib.Path(sys.argv[2]).write_text(svg)
