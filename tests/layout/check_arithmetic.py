# SPDX-License-Identifier: BSD-3-Clause
"""check_arithmetic.py ROOT: no source whose results enter a digest uses what differs by library, compiler or run."""

import re
import sys

import tree

WHERE = ("rt", "drivers", "estimators", "mapping", "planner", "hil", "firmware_like/parts", "firmware_like/robots")
RULES = [
    (r"std::(a?(sin|cos|tan)h?|atan2|exp2?|expm1|log(2|10|1p)?|pow|cbrt|hypot|fma|erfc?|[tl]gamma)f?\s*\(", "use rt/math.hpp"),
    (r"std::\w+_distribution\b", "the standard leaves distributions open: draw from the generator's bits"),
    (r"std::unordered_\w+", "the order of a hash table differs by library: use a sorted or indexed container"),
    (r"std::random_device\b", "seeds come from the profile"),
    (r"std::hash\b", "its values differ by library: hash with rt/digest.hpp"),
    (r"(ffast-math|funsafe-math|FP_CONTRACT\s+ON|GCC\s+optimize|__attribute__\s*\(\(\s*optimize)", "arithmetic flags belong to toolchain/options.cmake"),
]


def main(root):
    findings, checked = [], 0
    for path in tree.files(root, {".hpp", ".cpp"}, WHERE):
        checked += 1
        for number, line in enumerate((tree.pathlib.Path(root) / path).read_text().splitlines(), 1):
            code = "" if line.startswith("#error") else line.split("//")[0]
            for pattern, cure in RULES:
                match = re.search(pattern, code)
                if match:
                    findings.append(f"{path}:{number}: {match[0].strip()}: {cure}")
    tree.finish(findings, checked, "arithmetic")


main(sys.argv[1])
