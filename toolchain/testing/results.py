# SPDX-License-Identifier: BSD-3-Clause
"""Reads what ctest and the test binaries left, and tells of it: verdicts, the table of stages, the slowest tests."""

import pathlib
import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass


@dataclass
class Test:
    name: str
    verdict: str  # passed, failed, skipped
    seconds: float
    why: str = ""


def read_cases(folder, after):
    """The cases of the binaries that have run since `after`, by the name of their test."""
    found = {}
    for path in sorted(folder.glob("*.tsv")):
        if path.stat().st_mtime < after:
            continue
        rows = [line.split("\t") for line in path.read_text().splitlines()]
        found[path.stem] = [Test(name, verdict, float(seconds), why) for verdict, seconds, name, why in rows]
    return found


def read_ctest(junit, cases, prefix):
    """Every test that ctest ran; a binary of cases is told case by case."""
    tests = []
    for case in xml.parse(junit).getroot().iter("testcase"):
        name, status = case.get("name"), case.get("status")
        output = case.findtext("system-out") or ""
        seconds = float(case.get("time") or 0)
        verdict = {"run": "passed", "notrun": "skipped", "disabled": "skipped"}.get(status, "failed")
        skip = re.search(r"skipped: (.*)", output)
        short = name.removeprefix(prefix)
        inner = cases.get(short.replace("/", "-"))
        if inner is None:
            tests.append(Test(name, verdict, seconds, skip[1] if skip and verdict == "skipped" else ""))
            continue
        tests += [Test(f"{prefix}{short}: {test.name}", test.verdict, test.seconds, test.why) for test in inner]
        if verdict == "failed" and all(test.verdict != "failed" for test in inner):
            tests.append(Test(name, "failed", seconds, "the process"))
    return tests


def minutes(seconds):
    return f"{seconds / 60:.1f}"


def stage_table(rows):
    """rows: (name, seconds, tests, processor share), as Markdown."""
    lines = ["| stage | minutes | tests | failed | skipped | processor |", "|---|---:|---:|---:|---:|---:|"]
    for name, seconds, tests, share in rows:
        count = {verdict: sum(test.verdict == verdict for test in tests) for verdict in ("failed", "skipped")}
        used = f"{100 * share:.0f} %" if share <= 1 else "beside"  # most of its build went on beside the tests before
        lines.append(f"| {name} | {minutes(seconds)} | {len(tests)} | {count['failed']} | {count['skipped']} | {used} |")
    lines.append(f"| all | {minutes(sum(row[1] for row in rows))} | {sum(len(row[2]) for row in rows)} | | | |")
    return lines


def slowest_table(tests, count=10):
    lines = ["| slowest tests | s |", "|---|---:|"]
    for test in sorted(tests, key=lambda test: -test.seconds)[:count]:
        lines.append(f"| {test.name} | {test.seconds:.1f} |")
    return lines


def kept_times(page):
    """Minutes by stage of the page that is kept; empty where there is none."""
    if not page.exists():
        return {}
    found = re.findall(r"^\| ([^|]+?) \| ([0-9.]+) \|", page.read_text(), re.MULTILINE)
    return {name: 60 * float(minutes) for name, minutes in found if name != "all"}


def grown(rows, kept):
    """A line for each stage that took a third longer than the kept table says, by ten seconds at least."""
    return [f"{name} took {minutes(seconds)} minutes; {minutes(kept[name])} are kept"
            for name, seconds, _, _ in rows if name in kept and seconds > 4 / 3 * kept[name] and seconds > kept[name] + 10]


def machine():
    """This machine in a line."""
    info = pathlib.Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*: (.*)", info)
    memory = re.search(r"MemTotal:\s*(\d+)", pathlib.Path("/proc/meminfo").read_text())
    cores = info.count("processor\t")
    return f"{cores} processors ({model[1] if model else 'unknown'}), {int(memory[1]) // 2**20} GiB" if memory else f"{cores} processors"
