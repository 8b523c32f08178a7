// SPDX-License-Identifier: BSD-3-Clause
// Does a file live in memory only? Stores into its map then never wait for a disk.
#pragma once

#include <sys/vfs.h>

namespace sortie::rt::posix {

/// True for tmpfs, ramfs and hugetlbfs. `file`: an open descriptor.
inline bool on_memory_file_system(int file) noexcept {
  constexpr unsigned long kTmpfs = 0x01021994ul;
  constexpr unsigned long kRamfs = 0x858458f6ul;
  constexpr unsigned long kHugetlbfs = 0x958458f6ul;
  struct statfs found {};
  if (fstatfs(file, &found) != 0) return false;
  const unsigned long type = static_cast<unsigned long>(found.f_type) & 0xfffffffful;
  return type == kTmpfs || type == kRamfs || type == kHugetlbfs;
}

}  // namespace sortie::rt::posix
