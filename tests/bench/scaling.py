#!/usr/bin/env python3
"""Measures how a request's cost grows and draws it: ./dev bench scaling [REGULAR EXPRESSION [PROGRAM]]

Runs the benchmarks scaling/SUBJECT/SERIES/X, puts their figures into scaling.csv, of rows measured anew
only those, and draws scaling.svg as scaling.json says. Prints the slopes found.
"""

import csv
import datetime
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TABLE = HERE / "scaling.csv"
FIELDS = ["subject", "series", "x", "ms", "vertices", "evaluations"]


def measure(program, which):
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        subprocess.run([program, f"--benchmark_filter=^scaling/.*{which}", "--benchmark_min_time=0.2",
                        f"--benchmark_out={out.name}", "--benchmark_out_format=json"], check=True)
        for run in json.load(out)["benchmarks"]:
            if run.get("error_occurred"):
                raise SystemExit(f"scaling.py: {run['name']}: {run['error_message']}")
            subject, series, x = run["name"].split("/")[1:4]
            whole = lambda name: f"{run[name]:.0f}" if name in run else ""
            yield dict(zip(FIELDS, (subject, series, x, f"{run['min_ms']:.4g}", whole("vertices"),
                                    whole("evaluations"))))


def main():
    which = sys.argv[1] if len(sys.argv) > 1 else ""
    program = sys.argv[2] if len(sys.argv) > 2 else HERE.parents[1] / "build/release/isocaustic_bench"
    rows = {}
    if TABLE.exists():
        with open(TABLE, newline="") as file:
            rows = {tuple(row[f] for f in FIELDS[:3]): row
                    for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    rows |= {tuple(row[f] for f in FIELDS[:3]): row for row in measure(program, which)}
    commit = subprocess.run(["git", "describe", "--always", "--dirty", "--exclude=*"], cwd=HERE,
                            stdout=subprocess.PIPE, text=True).stdout.strip()
    with open(TABLE, "w") as file:
        file.write(f"# Minima. Last measured: commit {commit}, {datetime.date.today()}\n")
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows.values())
    return subprocess.run([sys.executable, HERE / "plot.py", HERE / "scaling.json", HERE / "scaling.svg"]).returncode


if __name__ == "__main__":
    sys.exit(main())
