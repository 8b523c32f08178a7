# SPDX-License-Identifier: BSD-3-Clause
"""check_headers.py ROOT COMPILE_COMMANDS: every header is the first thing that some compiled file includes, or stands there
behind nothing but what it includes itself, so that the build shows that it needs nothing before it. That file is the header's
own .cpp, unless it is compiled in a batch with others; then it is one of those that tests/layout/header_chains.py makes."""

import json
import sys

import header_chains
import tree


def shown_alone(root, path):
    """Headers that a compiled file shows to need nothing before them."""
    before = set()
    for name in header_chains.includes(path):
        reach = header_chains.reach(root, name)
        if not before or (before <= reach and name not in reach):
            yield name
        before.add(name)


def main(root, commands):
    root = tree.pathlib.Path(root)
    compiled = [tree.pathlib.Path(entry["file"]) for entry in json.loads(tree.pathlib.Path(commands).read_text())]
    shown = {name for path in compiled if path.exists() and "Unity" not in path.parts for name in shown_alone(root, path)}
    findings, checked = [], 0
    for header in tree.files(root, {".hpp"}, tree.FOLDERS):
        checked += 1
        if header.as_posix() in shown:
            continue
        own = header.with_suffix(".cpp")
        cure = f"{own} must include it first" if (root / own).exists() else "configure the build again"
        findings.append(f"{header}: nothing compiles it alone: {cure}")
    tree.finish(findings, checked, "headers")


main(sys.argv[1], sys.argv[2])
