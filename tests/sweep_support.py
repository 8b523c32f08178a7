# SPDX-License-Identifier: BSD-3-Clause
# What the tests of sweeps share: running the program, checks, and a table without its run times.
import csv
import io
import json
import pathlib
import subprocess
import sys
import tempfile

work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-sweep-"))
failures = []
# Run times and what follows from them; which command made the table.
TIMES = {"load_us_per_s", "p50_us", "p99_us", "max_us", "on_front", "command"}


def run(program, *arguments, **options):
    return subprocess.run([str(program), *map(str, arguments)], capture_output=True, text=True, timeout=600,
                          stdin=subprocess.DEVNULL, **options)


def check(good, what, result=None):
    if good:
        return good
    failures.append(what)
    print("FAILED", what, flush=True)
    if result is not None:
        print("  exit", result.returncode, "\n  stdout:", result.stdout[-1500:], "\n  stderr:", result.stderr[-1500:])
    return good


def finish(said):
    if failures:
        print(len(failures), "failed; files are left in", work)
        sys.exit(1)
    subprocess.run(["rm", "-rf", str(work)], check=True)
    print(said)


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in TIMES}
    if isinstance(value, list):
        return [without_times(item) for item in value]
    return value


# The bytes of a sweep's files without the run times: sweep.json and every CSV of a log.
def table(folder):
    texts = [json.dumps(without_times(json.loads((folder / "sweep.json").read_text())), indent=1)]
    for path in sorted(folder.glob("sweep*.csv")):
        rows = list(csv.reader(io.StringIO(path.read_text())))
        kept = [i for i, name in enumerate(rows[0]) if not name.endswith(tuple(TIMES))]
        texts.append("\n".join(",".join(row[i] for i in kept) for row in rows))
    return "\n".join(texts).encode()


def cells(folder):
    return sorted(int(path.name[5:10]) for path in folder.glob("cell-*.json"))


# Simulated drives of the hall, with an extra key of the profile each.
def drives(program, count, seconds):
    logs = []
    for seed in range(1, count + 1):
        logs.append(work / f"hall{seed}.lcm")
        made = run(program, "run", "--scene", "ugv_hall", "--virtual", "--seconds", seconds, "--lcm-url", "none",
                   "--set", f"hil.seed={seed}", "--record", logs[-1])
        check(made.returncode == 0, "a drive is simulated", made)
    return logs
