// SPDX-License-Identifier: BSD-3-Clause
// Whether the processor is an emulated one.
#pragma once

#include <fstream>
#include <iterator>
#include <string>

namespace sortie::rt::posix::test {

/// True for an ARM program on another processor, under an emulator of user programs: nothing that is timed
/// there means anything.
inline bool emulated() {
#if defined(__aarch64__) || defined(__arm__)
  std::ifstream file("/proc/cpuinfo");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return text.find("vendor_id") != std::string::npos;
#else
  return false;
#endif
}

}  // namespace sortie::rt::posix::test
