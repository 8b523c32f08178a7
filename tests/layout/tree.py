# SPDX-License-Identifier: BSD-3-Clause
"""What the layout checks share: the folders of the house, the files in them, and how a finding is reported."""

import pathlib
import sys

FOLDERS = ("rt", "drivers", "estimators", "mapping", "planner", "hil", "firmware_like", "toolchain")
IGNORED = {".git", "build", "out", ".cache", "__pycache__"}


def files(root, suffixes, folders=None):
    """All files below root with one of these suffixes, sorted, as paths relative to root."""
    root = pathlib.Path(root)
    for start in [root / folder for folder in folders] if folders else [root]:
        for path in sorted(start.rglob("*")):
            relative = path.relative_to(root)
            if path.is_file() and path.suffix in suffixes and not IGNORED & set(relative.parts):
                yield relative


def finish(findings, checked, what):
    """Prints the findings, one a line, and ends the program: 0 when there are none, 1 otherwise."""
    for finding in findings:
        print(finding)
    if checked == 0:
        print(f"{what}: nothing to check: is this the right root?")
        sys.exit(1)
    print(f"{what}: {checked} checked, {len(findings)} findings")
    sys.exit(1 if findings else 0)
