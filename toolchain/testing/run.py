# SPDX-License-Identifier: BSD-3-Clause
"""Runs the stages of stages.py; toolchain/test calls it when the packages are there."""

import argparse
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import threading
import time

import near
import results
from stages import STAGES

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
KEPT = ROOT / "docs/results/test-times.md"
JOBS = os.environ.get("SORTIE_JOBS", "2")
TESTS_AT_ONCE = str(2 * int(JOBS) + 1)  # what computes counts for two, many wait for a clock
SANITIZERS = {
    "ASAN_OPTIONS": "detect_stack_use_after_return=1:strict_string_checks=1",
    "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    "TSAN_OPTIONS": "halt_on_error=1:second_deadlock_stack=1",
}


def say(words):
    sys.stderr.write(f"test {time.monotonic() - BEGIN:5.0f} s  {words}\n")  # in one piece: builds speak from a thread of their own


def logged(words, log):
    """Runs a command with its output in a file; its exit code."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("a") as out:
        print("$", *words, file=out, flush=True)
        return subprocess.run(words, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, check=False).returncode


def expand(text):
    """${NAME:-default} from the environment."""
    return re.sub(r"\$\{(\w+):-([^}]*)\}", lambda found: os.environ.get(found[1], found[2]), text)


def build(preset, definitions, targets):
    """Configures and builds; what went wrong, or an empty text. Tests that run beside it go first."""
    log = BUILD / f"{preset}.log"
    log.unlink(missing_ok=True)
    configure = ["cmake", "--preset", preset, *map(expand, definitions)]
    make = ["cmake", "--build", "--preset", preset, "-j", JOBS, *(["--target", *targets] if targets else [])]
    if logged(configure, log) == 0 and logged(["nice", "-n", "19", *make], log) == 0:
        return ""
    lines = log.read_text(errors="replace").splitlines()
    found = [index for index, line in enumerate(lines) if re.search(r"\berror\b|Error|FAILED", line)]
    shown = lines[max(0, found[0] - 2):found[0] + 20] if found else lines[-30:]
    print("\n".join(shown), file=sys.stderr)
    return f"building {preset} failed, the whole story is in build/{preset}.log"


def ctest(preset, arguments):
    """Runs a preset's tests; what each gave."""
    begin = time.time() - 1
    junit = BUILD / preset / "junit.xml"
    junit.unlink(missing_ok=True)
    prefix = "" if preset == "release" else f"{preset} "
    subprocess.run(["ctest", "--test-dir", BUILD / preset, "-j", TESTS_AT_ONCE, "--output-on-failure", "--no-tests=error", "--output-junit", junit,
                    *arguments], cwd=ROOT, env={**os.environ, **SANITIZERS}, stdout=sys.stdout, stdin=subprocess.DEVNULL, check=False)
    if not junit.exists():
        return [results.Test(f"{preset}: ctest", "failed", 0, "no test ran")]
    return results.read_ctest(junit, results.read_cases(BUILD / preset / "cases", begin), prefix)


def command(title, words):
    begin = time.monotonic()
    code = subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, check=False).returncode
    verdict = {0: "passed", 77: "skipped"}.get(code, "failed")
    return results.Test(title, verdict, time.monotonic() - begin, f"exit code {code}" if code else "")


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Builds:
    """The builds of stages, one after the other in a thread: they go on while the tests of stages before wait for their clocks."""

    def __init__(self, stages):
        self.faults = {preset: "its build ended early" for stage in stages for preset, _, _ in stage.builds}
        self.built = {stage.name: threading.Event() for stage in stages}
        self.thread = threading.Thread(target=self.run, args=(stages,), daemon=True)
        self.thread.start()

    def run(self, stages):
        try:
            for stage in stages:
                for preset, definitions, targets in stage.builds:
                    say(f"{stage.name}: building {preset}")
                    try:
                        self.faults[preset] = build(preset, definitions, targets)
                    except OSError as error:
                        self.faults[preset] = f"building {preset}: {error}"
                self.built[stage.name].set()
        finally:
            for built in self.built.values():
                built.set()

    def wait(self, stage):
        """What went wrong with a stage's builds, by preset."""
        self.built[stage.name].wait()
        return {preset: self.faults[preset] for preset, _, _ in stage.builds if self.faults[preset]}


BROKEN = set()  # presets that did not build


def run_stage(stage, builds=None, then=None):
    """(name, seconds, tests, processor share) of a stage. `builds` may be under way already; `then` is called where its tests begin."""
    begin, used = time.monotonic(), processor_seconds()
    tests = [results.Test(f"{stage.name}: tests of {preset}", "failed", 0, "not run: it did not build")
             for preset, _ in stage.tests if preset in BROKEN]
    for preset, fault in (builds or Builds([stage])).wait(stage).items():
        BROKEN.add(preset)
        tests.append(results.Test(f"{stage.name}: build of {preset}", "failed", 0, fault))
    if then and (stage.tests or stage.commands):
        then()
    if not tests:
        if stage.tests or stage.commands:
            say(f"{stage.name}: running")
        for preset, arguments in stage.tests:
            tests += ctest(preset, arguments)
        tests += [command(title, words) for title, words in stage.commands]
    seconds = time.monotonic() - begin
    return stage.name, seconds, tests, (processor_seconds() - used) / max(1e-3, seconds * (os.cpu_count() or 1))


class State:
    """What stages of this very tree have passed, for --resume."""

    def __init__(self):
        self.path = BUILD / "stages.json"
        def git(*words):
            return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()

        changes = git("stash", "create")
        self.tree = git("rev-parse", f"{changes or 'HEAD'}^{{tree}}") + git("status", "--porcelain")
        known = json.loads(self.path.read_text()) if self.path.exists() else {}
        self.rows = known.get("rows", {}) if known.get("tree") == self.tree else {}

    def passed(self, name):
        row = self.rows.get(name)
        return row and (row[0], row[1], [results.Test(**test) for test in row[2]], row[3])

    def keep(self, row):
        self.rows[row[0]] = (row[0], row[1], [vars(test) for test in row[2]], row[3])
        BUILD.mkdir(exist_ok=True)
        self.path.write_text(json.dumps({"tree": self.tree, "rows": self.rows}))


def good(row):
    return all(test.verdict != "failed" for test in row[2])


def page(rows, tests, title, words, slowest):
    return "\n".join([f"# {title}", "", words, "", f"{results.machine()}; {time.strftime('%Y-%m-%d')}.", "",
                      *results.stage_table(rows), "", *results.slowest_table(tests, slowest), ""])


def finish(rows, options):
    tests = [test for row in rows for test in row[2]]
    counted = {verdict: [test for test in tests if test.verdict == verdict] for verdict in ("passed", "failed", "skipped")}
    print("\n".join(["", *results.stage_table(rows), "", *results.slowest_table(tests), ""]))
    reasons = {}
    for test in counted["skipped"]:
        reasons.setdefault(test.why or "see its output", []).append(test.name)
    for why, names in sorted(reasons.items()):
        print(f"skipped: {why}: {names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''}")
    for line in results.grown(rows, results.kept_times(KEPT)):
        print(f"slower than docs/results/test-times.md: {line}")
    for test in counted["failed"]:
        print(f"FAILED {test.name}{': ' + test.why if test.why else ''}")
    if options.keep:
        text = page(rows, tests, "How long a test run takes",
                    "`toolchain/test --keep` wrote this; a stage that takes a third longer is told at the end of a run. Builds begin beside the "
                    "tests before them: their minutes are what was left to wait for.", 10)
        if options.long:
            text = page(rows, tests, "The long tests", "What `toolchain/test --long` gave; `--keep` wrote this.", 25)
        (KEPT.with_name("long-tests.md") if options.long else KEPT).write_text(text)
    print(f"{len(counted['passed'])} passed, {len(counted['failed'])} failed, {len(counted['skipped'])} skipped", flush=True)
    return 1 if counted["failed"] or not counted["passed"] else 0


def arguments():
    parser = argparse.ArgumentParser(prog="toolchain/test", formatter_class=argparse.RawDescriptionHelpFormatter,
                                     description="Builds Sortie and tests it. Without options: the short run that a change must pass.",
                                     epilog="exit codes: 0 nothing failed, 1 something did, 2 usage\nstages:\n" +
                                     "\n".join(f"  {stage.name:22} {stage.what}{' (--long)' if stage.long else ''}" for stage in STAGES))
    parser.add_argument("--long", action="store_true", help="the stages that take hours, in their place behind the short ones")
    parser.add_argument("--only", metavar="STAGE,...", help="these stages alone, by the beginning of their names")
    parser.add_argument("--resume", action="store_true", help="leave out what has passed with this very tree")
    parser.add_argument("--keep", action="store_true", help="write the table to docs/results/test-times.md, with --long to long-tests.md")
    parser.add_argument("--near", nargs="+", metavar="FILE", help="build and run what stands next to these files, in the release build")
    return parser.parse_args()


def main():
    options = arguments()
    if options.near:
        return near.run(ROOT, JOBS, options.near)
    wanted = [stage for stage in STAGES if options.long or not stage.long]
    if options.only:
        names = [name.strip() for name in options.only.split(",")]
        unknown = [name for name in names if not any(stage.name.startswith(name) for stage in STAGES)]
        if unknown:
            print(f"toolchain/test: no stage '{unknown[0]}'; stages: {', '.join(stage.name for stage in STAGES)}", file=sys.stderr)
            return 2
        wanted = [stage for stage in STAGES if any(stage.name == name or stage.name.startswith(name + " ") for name in names)]
    state, rows, ahead = State(), [], None
    # The long stages build some presets again, differently.
    early = [stage for stage in wanted[1:] if not stage.long and not (options.resume and state.passed(stage.name))]
    for stage in wanted:
        def begin_early(stage=stage):
            nonlocal ahead
            ahead = ahead or Builds([one for one in early if wanted.index(one) > wanted.index(stage)])

        row = state.passed(stage.name) if options.resume else None
        if row:
            say(f"{stage.name}: has passed")
        else:
            row = run_stage(stage, ahead if stage in early else None, begin_early)
            if good(row):
                state.keep(row)
        rows.append(row)
        if options.long and options.keep:
            pathlib.Path(BUILD / "long-so-far.txt").write_text("\n".join(results.stage_table(rows)) + "\n")
    return finish(rows, options)


BEGIN = time.monotonic()
if __name__ == "__main__":
    sys.exit(main())
