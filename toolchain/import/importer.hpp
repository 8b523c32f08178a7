// SPDX-License-Identifier: BSD-3-Clause
// Recorded data sets -> LCM log: one call for all kinds. Every importer checks what it reads.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/scene/input_error.hpp"

namespace sortie::toolchain {

/// What to import and how strictly.
struct ImportOptions {
  std::string kind;          ///< husky, plaza, broad or rls
  std::string path;          ///< the data set's folder, or one of its files
  std::string out;           ///< LCM log to write
  bool strict{false};        ///< one bad row is an error
  double max_bad_rows{0.2};  ///< share of bad sensor rows that is an error even without `strict`
  std::ostream* notes{};     ///< where the line of each dropped row is printed; null = std::cerr
};

/// What was imported.
struct ImportReport {
  std::uint64_t rows{};          ///< rows, records or scans read, of sensors and truth
  std::uint64_t events{};        ///< events written
  std::uint64_t bad_rows{};      ///< sensor rows dropped: not a number, not finite, too few columns
  std::uint64_t hidden_truth{};  ///< truth rows without a usable reference (legal)
  std::uint64_t
      time_backwards{};  ///< sensor rows whose stamp lies before the row above (kept: the estimators judge)
  std::uint64_t imu{}, tracks{}, scans{}, truth{};  ///< events by kind
  std::vector<std::string> sources;                 ///< files read
  std::vector<std::string> warnings;                ///< truncated tails, gaps, missing truth
};

/// Imports `options.path` and writes `options.out` (written to a temporary name first, so a failed import
/// leaves no half log). Throws InputError with exit code 3 where the data cannot be used, 2 for an unknown
/// kind.
ImportReport import_log(const ImportOptions& options);

/// The kinds that import_log knows, for help texts.
std::vector<std::string> import_kinds();

}  // namespace sortie::toolchain
