// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/heap_watch.hpp"

namespace sortie::firmware {

namespace {
HeapWatch the_watch;
}  // namespace

void set_heap_watch(HeapWatch watch) { the_watch = watch; }
HeapWatch heap_watch() { return the_watch; }

}  // namespace sortie::firmware
