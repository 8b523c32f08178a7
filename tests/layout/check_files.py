# SPDX-License-Identifier: BSD-3-Clause
"""check_files.py ROOT: the habits of a file: licence line, #pragma once, length, links that lead somewhere, nothing
unfinished, no machine's paths."""

import re
import subprocess
import sys

import tree

LONGEST = {"tests": 500}
LONGEST_ELSEWHERE = 300
WORDS = [
    (re.compile(r"\b(TODO|FIXME|XXX|HACK)\b"), "unfinished work is not committed"),
    (re.compile(r"\b(for now|placeholder|simplified version|not implemented yet)\b", re.I), "say what it is, or finish it"),
    (re.compile(r"(^|[\s\"'=(:])/(work|home|root|Users)/\w"), "a path of one machine"),
    (re.compile(r"https?://[\w.-]*(deb\.|pypi|mirror|registry|npmjs|crates\.io)"), "a package host: apt knows its mirror"),
]


def listed(root):
    """Files that git knows or would take; outside a git tree, all files."""
    command = ["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode == 0:
        return [tree.pathlib.Path(line) for line in result.stdout.splitlines()]
    return [p.relative_to(root) for p in sorted(tree.pathlib.Path(root).rglob("*")) if p.is_file()]


def look(path, text):
    lines = text.splitlines()
    if path.suffix in {".hpp", ".cpp"}:
        if not lines or lines[0] != "// SPDX-License-Identifier: BSD-3-Clause":
            yield f"{path}:1: the first line names the licence"
        if path.suffix == ".hpp" and "#pragma once" not in lines:
            yield f"{path}:1: a header says #pragma once"
        longest = LONGEST.get(path.parts[0], LONGEST_ELSEWHERE)
        if len(lines) > longest:
            yield f"{path}:{longest}: {len(lines)} lines: one idea a file, at most {longest} lines"
    for number, line in enumerate(lines, 1):
        for pattern, why in WORDS:
            match = pattern.search(line)
            if match:
                yield f"{path}:{number}: '{match[0].strip()}': {why}"


CASE = re.compile(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)')


def look_at_cases(path, text):
    for match in CASE.finditer(text):
        if ";" in match[1]:
            line = text.count("\n", 0, match.start()) + 1
            yield f"{path}:{line}: CTest cuts the name of a case at its semicolon and then finds no such case"


LINK = re.compile(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)")


def look_at_links(root, path, text):
    for match in LINK.finditer(text):
        if not (tree.pathlib.Path(root) / path.parent / match[1]).exists():
            line = text.count("\n", 0, match.start()) + 1
            yield f"{path}:{line}: the link to {match[1]} leads nowhere"


def look_at_packages(path, text):
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip() and not line.startswith("#") and not re.fullmatch(r"\w+\s+[a-z0-9.+-]+\s+# \S.*", line):
            yield f"{path}:{number}: a package line is: group, package, # reason"


PART = re.compile(r'(?:kBuilt<|OwnedPart<[\w:]+, )"(\w+)"')


def part_names(root):
    """Names that may stand in kBuilt<"...">: of the list, and the robots'. One that stands nowhere is never built."""
    path = tree.pathlib.Path(root) / "firmware_like" / "scene" / "part_list.hpp"
    return {"ugv", "uav"} | set(re.findall(r"^  (?:part|option)\((\w+)", path.read_text(), re.M) if path.exists() else [])


def look_at_parts(path, text, known):
    for match in PART.finditer(text):
        if match[1] not in known:
            line = text.count("\n", 0, match.start()) + 1
            yield f'{path}:{line}: part "{match[1]}" is not in firmware_like/scene/part_list.hpp'


def main(root):
    findings, checked = [], 0
    parts = part_names(root)
    for path in listed(root):
        try:
            text = (tree.pathlib.Path(root) / path).read_text()
        except (UnicodeDecodeError, FileNotFoundError, IsADirectoryError):
            continue  # Pictures and other bytes.
        if path.parts[:2] == ("tests", "layout"):
            continue  # The rules and their planted faults name what they forbid.
        checked += 1
        findings += look(path, text)
        findings += look_at_cases(path, text)
        if path.suffix in {".hpp", ".cpp"}:
            findings += look_at_parts(path, text, parts)
        if path.suffix == ".md":
            findings += look_at_links(root, path, text)
        if path.name == "debian12-packages.txt":
            findings += look_at_packages(path, text)
    tree.finish(findings, checked, "files")


main(sys.argv[1])
