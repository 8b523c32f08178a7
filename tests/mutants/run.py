#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""run.py [--build DIR] [--only WORD]... [--jobs N] [--page FILE] | --list | --check: puts one fault of faults.toml after another
into a copy of its file, compiles what includes that file, links one file of tests with it, and sees a case fail. The sources are
never touched, so a run that is killed leaves no fault behind. DIR (build/release) is a tree that CMake made for Ninja; the
libraries are built in it where they are not. First every test file runs without a fault and must pass.
--only takes faults whose name holds WORD; --page then renews their rows alone. --check reads the list only: every text stands once
in its file, and the page has a row for every fault.
Exit code 0: all caught. 1: one was not, or the list is wrong."""

import argparse
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from listed import ListError, check, load, rows_of, write_page
from programs import Program, Tree

HERE = pathlib.Path(__file__).resolve().parent


def main():
    parser = argparse.ArgumentParser(description="puts faults of one line into the program and sees them caught")
    parser.add_argument("--root", type=pathlib.Path, default=HERE.parents[1])
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--faults", type=pathlib.Path, default=HERE / "faults.toml")
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--jobs", type=int, default=int(os.environ.get("SORTIE_JOBS", "2")))
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    root = options.root.resolve()
    faults = load(options.faults)
    if options.check:
        return check(root, faults, options.page or root / "docs/results/mutants.md")
    chosen = [fault for fault in faults if not options.only or any(word in fault["name"] for word in options.only)]
    if options.list:
        print("\n".join(f"{fault['name']}: {fault['file']}, {fault['test']}" for fault in chosen))
        return 0
    tree = Tree(root, (options.build or root / "build/release").resolve(), options.jobs)
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="sortie-faults-"))
    rows = {} if not options.page else {name: row for name, row in rows_of(options.page).items() if options.only}
    missed = 0

    def program(test):
        try:
            return Program(tree, test, scratch)
        except (ListError, subprocess.TimeoutExpired) as error:
            return ListError(str(error))

    def trial(fault, index):
        found = programs[fault["test"]].result()
        begin = time.monotonic()
        folder = scratch / str(index)
        try:
            if isinstance(found, ListError):
                raise found
            how = found.trial(fault, folder)
        except (ListError, subprocess.TimeoutExpired) as error:
            return "ERROR", str(error), 0.0
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        return "caught" if how else "NOT CAUGHT", how, time.monotonic() - begin

    try:
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            programs = {test: pool.submit(program, test) for test in dict.fromkeys(fault["test"] for fault in chosen)}
            trials = [pool.submit(trial, fault, index) for index, fault in enumerate(chosen)]
            for fault, result in zip(chosen, trials):
                verdict, how, seconds = result.result()
                missed += verdict != "caught"
                case = how.replace("|", "/") if verdict == "caught" else f"**{verdict}**"
                rows[fault["name"]] = f"| {fault['name']} | `{fault['file']}` | `{fault['test']}` | {case} |"
                print(f"{verdict} ({seconds:.0f} s)  {fault['name']}: {how}", flush=True)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    if options.page:
        write_page(options.page, faults, rows)
    print(f"{len(chosen) - missed} of {len(chosen)} caught")
    return 1 if missed or not chosen else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (ListError, ValueError) as wrong:
        sys.exit(f"run.py: {wrong}")
