# SPDX-License-Identifier: BSD-3-Clause
"""check_orders.py ROOT: whoever writes a memory order says what would miss it (docs/architecture.md, Memory orders). x86
hides a wrong one from every test that runs on it."""

import re
import sys

import tree

ORDER = re.compile(r"memory_order(_|::)(release|acquire|acq_rel|consume|seq_cst)")

RING = "tests/rt/queue_model_test.cpp"
OVERWRITE = "tests/rt/queue_overwrite_model_test.cpp"
LEDGER = "tests/rt/ledger_model_test.cpp"
FLAG = ""  # a flag before plain data, or one word by itself: the thread sanitizer sees the former
# The model test that takes the orders of a file away one by one, or FLAG.
PROVEN = {
    "rt/spsc_protocol.hpp": RING,
    "rt/mailbox.hpp": RING,
    "rt/overwrite_ring.hpp": OVERWRITE,
    "rt/atomic_words.hpp": OVERWRITE,
    "rt/ledger.hpp": LEDGER,
    "rt/let_channel.hpp": LEDGER,
    "rt/posix/interval_log.hpp": "tests/rt/interval_log_model_test.cpp",
    "rt/posix/fast_clock.hpp": OVERWRITE,  # the ring's protocol once more, word by word: twice as fast as through the ring
    "firmware_like/runtime/arrivals.hpp": "tests/firmware_like/arrivals_model_test.cpp",
    "rt/posix/flight_format.hpp": "tests/rt/flight_ring_damage_test.cpp",  # the check word, not the orders
    "rt/posix/flight_ring.cpp": FLAG,
    "rt/posix/supervisor.cpp": FLAG,
    "rt/posix/supervisor.hpp": FLAG,
    "rt/posix/live_runner.cpp": FLAG,
    "rt/posix/live_runner.hpp": FLAG,
    "rt/posix/crash_note.cpp": FLAG,
    "firmware_like/link/plant_link.cpp": FLAG,
    "drivers/can_stub_run.cpp": FLAG,
    "drivers/can_stub_node.hpp": FLAG,
    "drivers/lcm_publisher.cpp": FLAG,
}


def main(root):
    findings, checked = [], 0
    for path in tree.files(root, {".hpp", ".cpp"}, tree.FOLDERS):
        checked += 1
        lines = (tree.pathlib.Path(root) / path).read_text().splitlines()
        orders = [number for number, line in enumerate(lines, 1) if ORDER.search(line.split("//")[0])]
        proof = PROVEN.get(str(path))
        if orders and proof is None:
            findings.append(f"{path}:{orders[0]}: a memory order that no model takes away: make the atomic a template parameter, "
                            "model it (tests/rt/model_orders.hpp), and name the test in tests/layout/check_orders.py")
        elif not orders and proof is not None:
            findings.append(f"{path}: has no memory order any more: leave it out of tests/layout/check_orders.py")
        elif proof and not (tree.pathlib.Path(root) / proof).exists():
            findings.append(f"{path}: {proof} is gone")
    if (tree.pathlib.Path(root) / "CMakeLists.txt").exists():  # the whole tree
        findings += [f"{path}: is gone: leave it out of tests/layout/check_orders.py" for path in PROVEN
                     if not (tree.pathlib.Path(root) / path).exists()]
    tree.finish(findings, checked, "memory orders")


main(sys.argv[1])
