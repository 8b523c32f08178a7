#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sees run.py --check pass on a small tree, and fail at each fault that is planted in its list, its sources or its page."""

import contextlib
import io
import pathlib
import sys
import tempfile

import listed

SOURCE = "int twice(int x) { return 2 * x; }\nint thrice(int x) { return 3 * x; }\n"
FAULT = {"name": "rt: twice is once", "file": "rt/base.cpp", "find": "2 * x", "put": "1 * x", "test": "rt/base_test"}
OTHER = {**FAULT, "name": "rt: thrice is once", "find": "3 * x"}
ROW = "| {name} | `{file}` | `{test}` | a case |"

# What is planted: fields of the first fault, the source, the names in the page; and what must be said.
PLANTED = [
    ({"find": "4 * x"}, SOURCE, None, "holds the text 0 times"),
    ({"find": "* x"}, SOURCE, None, "holds the text 2 times"),
    ({}, SOURCE.replace("2 *", "2*"), None, "holds the text 0 times"),
    ({"put": "2 * x"}, SOURCE, None, "changes nothing"),
    ({"file": "rt/gone.cpp"}, SOURCE, None, "holds the text 0 times"),
    ({"test": "rt/gone_test"}, SOURCE, None, "there is no tests/rt/gone_test.cpp"),
    ({"name": OTHER["name"]}, SOURCE, None, "two faults have the name"),
    ({}, SOURCE, [OTHER["name"]], "has no row for 'rt: twice is once'"),
    ({}, SOURCE, [FAULT["name"], OTHER["name"], "rt: gone"], "has a row for 'rt: gone'"),
]


def check(root, faults, source, names):
    for path, text in (("rt/base.cpp", source), ("tests/rt/base_test.cpp", "")):
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    page = root / "page.md"
    page.write_text("\n".join([*listed.HEAD, *(ROW.format(**{**FAULT, "name": name}) for name in names), "", f"{len(names)} faults.", ""]))
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = listed.check(root, faults, page)
    return code, said.getvalue()


def page_of_a_survivor(root):
    """A page that says that a fault went through."""
    result, _ = check(root, [FAULT, OTHER], SOURCE, [FAULT["name"], OTHER["name"]])
    page = root / "page.md"
    page.write_text(page.read_text().replace("| a case |", "| **NOT CAUGHT** |", 1))
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        return result == 0 and listed.check(root, [FAULT, OTHER], page) == 1 and "is not caught" in said.getvalue()


with tempfile.TemporaryDirectory() as folder:
    place = pathlib.Path(folder)
    both = [FAULT["name"], OTHER["name"]]
    result, text = check(place, [FAULT, OTHER], SOURCE, both)
    missed = [] if result == 0 else [f"the clean list is refused: {text}"]
    for fields, code, rows, words in PLANTED:
        mine = {**FAULT, **fields}
        result, text = check(place, [mine, OTHER], code, [mine["name"], OTHER["name"]] if rows is None else rows)
        if result != 1 or words not in text:
            missed.append(f"not caught: {words}: exit code {result}, {text}")
    if not page_of_a_survivor(place):
        missed.append("a page with a fault that nothing caught is taken")
    if check(place, [], SOURCE, [])[0] != 1:
        missed.append("a list without faults is taken")
print("\n".join([*missed, f"{len(PLANTED) + 3 - len(missed)} of {len(PLANTED) + 3} as they should be"]))
sys.exit(1 if missed else 0)
