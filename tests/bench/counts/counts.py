#!/usr/bin/env python3
"""Counts instructions with callgrind and compares them with the baseline: ./dev bench counts

Instructions do not depend on the machine's speed or load; for one build they repeat to the last
digit, or to a thousandth where threads and zlib take part. They do depend on the compiler, which
the baseline names. Ends with 1 if something takes over a tenth more than it did.
"""

import argparse
import concurrent.futures
import csv
import datetime
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
BASELINE = HERE / "baseline.csv"
REGRESSION = 0.10
FIELDS = ["subject", "instructions", "units", "unit"]
ROUND_TRIP, TRIPS, EXAMPLE = "http/round_trip", 8, "ellipsoid-bowl"


# ---- Tables --------------------------------------------------------------------------------------


def read_table(path):
    with open(path, newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {row["subject"]: row for row in rows}


def write_table(table, remarks, file):
    file.writelines(f"# {remark}\n" for remark in remarks)
    writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table.values())


def compare(baseline, measured):
    """What got worse, what got better, what is new or gone: lists of lines."""
    worse, better, other = [], [], []
    for subject, row in baseline.items():
        if subject not in measured:
            worse.append(f"{subject}: no longer counted")
            continue
        before, now = int(row["instructions"]), int(measured[subject]["instructions"])
        line = f"{subject}: {before:,} -> {now:,} instructions, {100 * (now / before - 1):+.1f} %"
        if now > before * (1 + REGRESSION):
            worse.append(line)
        elif now < before * (1 - REGRESSION):
            better.append(line)
    other += [f"{subject}: not in the baseline" for subject in measured if subject not in baseline]
    return worse, better, other


def report(baseline, measured):
    worse, better, other = compare(baseline, measured)
    for title, lines in ("regressions", worse), ("improvements", better), ("new", other):
        print(f"{len(lines)} {title}" + "".join(f"\n  {line}" for line in lines))
    return 1 if worse else 0


# ---- Counting ------------------------------------------------------------------------------------


def callgrind(command, folder, toggle=None):
    """Starts the command under callgrind; its counts will be in the file that is returned too."""
    counts = tempfile.NamedTemporaryFile(dir=folder, delete=False).name
    valgrind = ["valgrind", "-q", "--tool=callgrind", f"--callgrind-out-file={counts}"]
    if toggle:
        valgrind.append(f"--toggle-collect={toggle}")
    return subprocess.Popen(valgrind + command, stdout=subprocess.PIPE, text=True), counts


def total(counts):
    for line in pathlib.Path(counts).read_text().splitlines():
        if line.startswith("summary:") or line.startswith("totals:"):
            return int(line.split()[1])
    raise SystemExit(f"counts.py: callgrind left no total in {counts}")


def count_subject(program, subject, folder):
    process, counts = callgrind([program, subject], folder, "caustic::bench::counted*")
    units, unit = process.communicate()[0].strip().split(" ", 1)
    if process.returncode:
        raise SystemExit(f"counts.py: {subject} ended with {process.returncode}")
    return dict(zip(FIELDS, (subject, total(counts), units, unit)))


def ask(port, path, body=None):
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", body and body.encode(),
                                     {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=600) as answer:
        return answer.read()


def count_serving(server, trips, folder):
    """All that a server does in its life, in which it answers so many POSTs and GETs of the .vtp."""
    data = tempfile.mkdtemp(dir=folder)
    process, counts = callgrind(
        [server, "serve", "--port", "0", "--data", data, "--log", "off"], folder)
    try:
        port = int(process.stdout.readline().strip().rsplit(":", 1)[1].rstrip("/"))
        body = json.loads(ask(port, f"/v1/examples/{EXAMPLE}"))
        body["limits"] = {"time_ms": 60_000}
        for _ in range(trips):
            body["scene"]["light"]["position"][0] *= 1 + 1e-6  # no answer is known before
            answer = json.loads(ask(port, "/v1/contours", json.dumps(body)))
            ask(port, answer["files"]["vtp"])
    finally:
        process.terminate()
        process.wait()
    return total(counts)


def count_round_trip(server, folder):
    """A round trip of the program itself, sockets and threads included: the difference between two lives."""
    few, many = (count_serving(server, trips, folder) for trips in (2, 2 + TRIPS))
    return dict(zip(FIELDS, (ROUND_TRIP, (many - few) // TRIPS, 1, "round trips")))


def measure(programs, prefixes, jobs):
    counts, server = (str(programs / name) for name in ("isocaustic_counts", "isocaustic"))
    names = subprocess.run([counts], stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    names = [name for name in names + [ROUND_TRIP] if name.startswith(tuple(prefixes or [""]))]
    if not names:
        raise SystemExit("counts.py: nothing is called that")
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        one = lambda name: (count_round_trip(server, folder) if name == ROUND_TRIP
                            else count_subject(counts, name, folder))
        table = {}
        for row in pool.map(one, names):
            table[row["subject"]] = row
            print(f"{row['subject']:32} {row['instructions']:>14,}   "
                  f"{row['instructions'] / int(row['units']):>12,.0f} for each of {row['units']} {row['unit']}",
                  flush=True)
    return table


def remarks(programs):
    first_line = lambda *command: subprocess.run(
        command, stdout=subprocess.PIPE, text=True, cwd=HERE).stdout.split("\n")[0]
    commit = first_line("git", "describe", "--always", "--dirty", "--exclude=*")
    return [f"Instructions by callgrind; the last column is what the one before counts. Commit {commit}, "
            f"{datetime.date.today()},", f"{first_line('c++', '--version')}, "
            f"{first_line('valgrind', '--version')}, preset {programs.name}"]


def main():
    parser = argparse.ArgumentParser(prog="./dev bench counts", description=__doc__.split("\n")[0])
    parser.add_argument("subjects", nargs="*", help="beginnings of names; default: all")
    parser.add_argument("--write", action="store_true", help="make what is counted the baseline")
    parser.add_argument("--baseline", type=pathlib.Path, default=BASELINE)
    parser.add_argument("--of", type=pathlib.Path, help="compare this table, count nothing")
    parser.add_argument("--programs", type=pathlib.Path, default=HERE.parents[2] / "build/release")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()

    measured = read_table(options.of) if options.of else measure(options.programs, options.subjects,
                                                                 options.jobs)
    baseline = read_table(options.baseline) if options.baseline.exists() else {}
    if options.write:
        merged = {**baseline, **measured} if options.subjects else measured
        said = remarks(options.programs)  # before this changes a file of the commit
        with open(options.baseline, "w") as file:
            write_table(merged, said, file)
        return 0
    if not baseline:
        raise SystemExit(f"counts.py: no baseline in {options.baseline}")
    if options.subjects:
        baseline = {name: row for name, row in baseline.items() if name.startswith(tuple(options.subjects))}
    return report(baseline, measured)


if __name__ == "__main__":
    sys.exit(main())
