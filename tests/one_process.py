#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""one_process.py [--limit SECONDS] [--notes FILE] [--tags SPEC] [--part K/N] COMMAND...: runs the cases of a Catch2 binary in
one process; with --part only every Nth of them, from the Kth. Where it fails, dies or hangs, the cases that are not known to
be good run again, each in a process of its own, so that the culprit has its name. FILE gets a line a case: passed, failed or
skipped, seconds, name, why. Exit code 0: every case passed, 1: not, or there was no case, 77: no case fits tags and part."""

import argparse
import os
import pathlib
import signal
import subprocess
import sys
import tempfile

parser = argparse.ArgumentParser(add_help=False)
parser.add_argument("--limit", type=float, default=600)
parser.add_argument("--notes", default="")
parser.add_argument("--tags", default="")
parser.add_argument("--part", default="1/1")
parser.add_argument("command", nargs=argparse.REMAINDER)
options = parser.parse_args()
part, parts = map(int, options.part.split("/"))
scratch = pathlib.Path(tempfile.mkdtemp(prefix="sortie-cases-"))


class Case:
    def __init__(self, name):
        self.name, self.verdict, self.seconds, self.why = name, "died", 0.0, ""


def run(arguments, limit):
    """The process's exit code or what ended it, and its cases in their order."""
    notes = scratch / "notes"
    notes.write_text("")
    environment = {**os.environ, "SORTIE_TEST_NOTES": str(notes)}
    process = subprocess.Popen([*options.command, *arguments], env=environment, start_new_session=True)
    try:
        code = process.wait(limit)
        end = f"exit code {code}" if code >= 0 else signal.Signals(-code).name
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGABRT)
        process.wait()
        code, end = -1, f"more than {limit:g} s"
    sys.stdout.flush()
    cases = []
    for line in notes.read_text(errors="replace").splitlines():
        word, _, rest = line.partition("\t")
        if word == "begin":
            cases.append(Case(rest))
        elif word == "skip":
            cases[-1].why = rest
        elif word in ("passed", "failed"):
            cases[-1].seconds = float(rest)
            cases[-1].verdict = "skipped" if cases[-1].why and word == "passed" else word
    return code, end, cases


def names(tags):
    """All cases of the binary that fit the tags."""
    words = [tags] if tags else []
    listed = subprocess.run([*options.command, "--list-test-names-only", *words], capture_output=True, text=True, check=False)
    return [line.strip() for line in listed.stdout.splitlines() if line.strip()]


def of_part(cases):
    return cases[part - 1 :: parts]


def by_name(wanted):
    """Arguments that choose cases by their exact names, whatever characters they hold."""
    file = scratch / "wanted"
    file.write_text("".join('"' + name.replace("\\", "\\\\").replace(",", "\\,") + '"\n' for name in wanted))
    return ["-f", str(file)]


def alone(name, limit):
    code, end, cases = run(by_name([name]), limit)
    case = cases[0] if cases else Case(name)
    if case.verdict in ("passed", "skipped") and code != 0:
        case.verdict, case.why = "failed", end  # its asserts held, its process did not: a leak, an abort at the end
    elif case.verdict == "died":
        case.verdict, case.why = "failed", end
    return case


def main():
    chosen = [options.tags] if options.tags else []
    if parts > 1:
        chosen = by_name(of_part(names(options.tags)) or ["no case of this name"])
    code, end, cases = run(chosen, options.limit)
    if not cases and not of_part(names(options.tags)) and names(""):
        print(f"skipped: no case fits {options.tags} {options.part}")
        return 77, []
    if not cases:
        print(f"no case ran: {end}")
        return 1, []
    if code == 0:
        return 0, cases
    print(f"\n--- the process ended with {end}; the cases that are not known to be good now run alone")
    done = {case.name: case for case in cases}
    # Asserts that failed name their case; a process that died or said "leak" at its end does not.
    suspects = [case.name for case in cases if case.verdict in ("failed", "died")]
    missing = [name for name in of_part(names(options.tags)) if name not in done]
    if not suspects and not missing:
        suspects = [case.name for case in cases]
    for name in [*suspects, *missing]:
        before = done.get(name)
        case = alone(name, options.limit)
        if before is not None and before.verdict in ("failed", "died") and case.verdict in ("passed", "skipped"):
            case.verdict, case.why = "failed", f"{before.verdict} beside the others ({end}), passed alone"
        if case.verdict == "failed":
            print(f"--- FAILED {name}: {case.why or 'see above'}")
        done[name] = case
    if all(case.verdict in ("passed", "skipped") for case in done.values()):
        print(f"--- FAILED: every case passed alone, together they ended with {end}")
        done["all together"] = Case("all together")
        done["all together"].verdict = "failed"
        done["all together"].why = end
    return 1, list(done.values())


result, told = main()
if options.notes:
    pathlib.Path(options.notes).parent.mkdir(parents=True, exist_ok=True)
    pathlib.Path(options.notes).write_text(
        "".join(f"{case.verdict}\t{case.seconds:.3f}\t{case.name}\t{case.why}\n" for case in told))
counted = {verdict: sum(case.verdict == verdict for case in told) for verdict in ("passed", "failed", "skipped")}
print(f"cases: {counted['passed']} passed, {counted['failed']} failed, {counted['skipped']} skipped")
sys.exit(result)
