// SPDX-License-Identifier: BSD-3-Clause
// The files in which a Linux machine tells about itself, below a root that may be another folder in tests.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sortie::firmware {

/// Reads small text files of /proc and /sys. Nothing is ever written.
class MachineFiles {
 public:
  /// `root`: "/" or a folder that holds proc, sys, dev.
  explicit MachineFiles(std::string root);

  /// True when this is the machine that the program runs on, so that it may also be asked directly.
  bool is_own() const { return root_.empty(); }
  /// The whole file without white space at its end, at most 1 MB; nothing when it cannot be read.
  std::optional<std::string> read(const std::string& path) const;
  /// The first whole number of a file.
  std::optional<std::int64_t> number(const std::string& path) const;
  /// Names in a folder, sorted; empty when it cannot be read.
  std::vector<std::string> names(const std::string& folder) const;
  bool exists(const std::string& path) const;
  /// True when this process may write the file. Does not open it.
  bool writable(const std::string& path) const;

 private:
  std::string root_;  ///< empty for "/"
};

/// "0-2,5" -> {0, 1, 2, 5}; what is no list of cores, such as "(null)", gives none.
std::vector<int> parse_core_list(const std::string& text);
/// {0, 1, 2, 5} -> "0-2,5"; "none" when empty. `cores` must rise.
std::string describe_cores(const std::vector<int>& cores);
/// Lines without their ends.
std::vector<std::string> split_lines(const std::string& text);
/// A whole number, or nothing when `word` is something else.
std::optional<std::int64_t> to_number(const std::string& word);

}  // namespace sortie::firmware
