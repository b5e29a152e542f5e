#!/usr/bin/env python3
"""What the plan is worth: each example as planned and with each stage that it skips: ./dev bench plan

Times are minima over runs in turns, of the solver alone, as the answer tells them. That curves stay
the same is asserted by tests/service/skipped_stages_test.cpp; here only the bytes are compared.
"""

import argparse
import csv
import datetime
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
FIELDS = ["example", "stage", "planned_ms", "forced_ms", "planned_evaluations", "forced_evaluations", "same_bytes"]


class Program:
    def __init__(self, path):
        self.path = path

    def run(self, *arguments, text=None):
        done = subprocess.run([self.path, *arguments], input=text, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
        return done.stdout

    def examples(self):
        return [line.split()[0] for line in self.run("example").splitlines()]

    def stages(self):
        help_text = self.run("trace", "--help").split("--no-skip", 1)[1]
        return help_text[help_text.index("{") + 1 : help_text.index("}")].split(",")

    def trace(self, request, kind, forced):
        return self.run("trace", "-", "--format", kind, *forced, text=request)


def measure(program, example, runs):
    """Rows for one example: planned against each stage of those it skips that can be forced."""
    request = json.loads(program.run("example", example))
    request["limits"] = {"time_ms": 60_000}
    request = json.dumps(request)
    skipped = [s["stage"] for s in json.loads(program.trace(request, "json", []))["skipped"]]
    ways = {stage: ["--no-skip", stage] for stage in program.stages() if stage in skipped}
    ways = {"": [], **ways}
    least, evaluations = {}, {}
    for _ in range(runs):
        for stage, forced in ways.items():
            work = json.loads(program.trace(request, "json", forced))["work"]
            least[stage] = min(1e3 * work["seconds"], least.get(stage, 1e9))
            evaluations[stage] = work["evaluations"]
    bytes_of = {stage: program.trace(request, "csv", forced) for stage, forced in ways.items()}
    for stage in filter(None, ways):
        same = "yes" if bytes_of[stage] == bytes_of[""] else "no"
        yield dict(zip(FIELDS, (example, stage, f"{least['']:.2f}", f"{least[stage]:.2f}",
                                evaluations[""], evaluations[stage], same)))


def print_table(rows, stages):
    stages = [stage for stage in stages if any(row["stage"] == stage for row in rows)]
    print("| example | ms | " + " | ".join(f"`{stage}`" for stage in stages) + " |")
    print("|---" * (2 + len(stages)) + "|")
    for example in dict.fromkeys(row["example"] for row in rows):
        own = {row["stage"]: row for row in rows if row["example"] == example}
        planned = next(iter(own.values()))["planned_ms"]
        cells = []
        for stage in stages:
            row = own.get(stage)
            cells.append("" if not row else f"{float(row['forced_ms']):.1f}" +
                         ("" if row["same_bytes"] == "yes" else " *"))
        print(f"| {example} | {float(planned):.1f} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(prog="./dev bench plan", description=__doc__.split("\n")[0])
    parser.add_argument("examples", nargs="*", help="default: all")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--program", default=str(HERE.parents[1] / "build/release/isocaustic"))
    parser.add_argument("--csv", type=pathlib.Path, help="write the rows there too")
    options = parser.parse_args()
    program = Program(options.program)
    rows = [row for example in options.examples or program.examples()
            for row in measure(program, example, options.runs)]
    print_table(rows, program.stages())
    if options.csv:
        commit = subprocess.run(["git", "describe", "--always", "--dirty", "--exclude=*"], cwd=HERE,
                                stdout=subprocess.PIPE, text=True).stdout.strip()
        with open(options.csv, "w") as file:
            file.write(f"# Commit {commit}, {datetime.date.today()}; minima of {options.runs} runs\n")
            writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
