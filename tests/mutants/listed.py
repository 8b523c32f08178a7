# SPDX-License-Identifier: BSD-3-Clause
"""The list of faults of one line, what it says of the sources, and the page that tells what caught each."""

import collections
import tomllib

FIELDS = {"name", "file", "find", "put", "test"}
HEAD = ["# Faults of one line", "",
        "`tests/mutants/run.py --page docs/results/mutants.md` puts each of these faults of",
        "[faults.toml](../../tests/mutants/faults.toml) into the program by itself and names the first case that fails. The list is",
        "part of `toolchain/test --long`.", "", "| fault | file | caught by | case |", "|---|---|---|---|"]


class ListError(Exception):
    """The list is wrong, or does not fit the tree."""


def load(path):
    faults = tomllib.loads(path.read_text()).get("fault", [])
    for fault in faults:
        if set(fault) != FIELDS:
            raise ListError(f"{fault.get('name', fault)}: a fault has {', '.join(sorted(FIELDS))}, and nothing else")
    return faults


def changed(root, fault):
    """The file's text with the fault in it."""
    path = root / fault["file"]
    text = path.read_text() if path.is_file() else ""
    times = text.count(fault["find"])
    if times != 1:
        raise ListError(f"{fault['name']}: {fault['file']} holds the text {times} times, not once: {fault['find']!r}")
    if fault["find"] == fault["put"]:
        raise ListError(f"{fault['name']}: changes nothing")
    return text.replace(fault["find"], fault["put"])


def rows_of(page):
    """The page's rows by the fault's name."""
    lines = page.read_text().splitlines() if page.is_file() else []
    return {line.split(" | ")[0].removeprefix("| "): line for line in lines[len(HEAD):] if line.startswith("| ")}


def check(root, faults, page):
    problems = [f"two faults have the name {name!r}" for name, n in collections.Counter(f["name"] for f in faults).items() if n > 1]
    for fault in faults:
        try:
            changed(root, fault)
        except ListError as error:
            problems.append(str(error))
        if not (root / f"tests/{fault['test']}.cpp").is_file():
            problems.append(f"{fault['name']}: there is no tests/{fault['test']}.cpp")
    names, rows = {fault["name"] for fault in faults}, set(rows_of(page))
    problems += [f"{page.name} has no row for {name!r}: run.py --only ... --page" for name in sorted(names - rows)]
    problems += [f"{page.name} has a row for {name!r}, which the list has not" for name in sorted(rows - names)]
    problems += [f"{page.name}: {name!r} is not caught" for name, row in rows_of(page).items() if "| **" in row]
    print("\n".join([*problems, f"faults: {len(faults)} read, {len(problems)} problems"]))
    return 1 if problems or not faults else 0


def write_page(page, faults, rows):
    order = [rows[fault["name"]] for fault in faults if fault["name"] in rows]
    page.write_text("\n".join([*HEAD, *order, "", f"{len(order)} faults.", ""]))
