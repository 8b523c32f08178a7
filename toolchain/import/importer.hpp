// SPDX-License-Identifier: BSD-3-Clause
// Recorded data sets -> LCM log: one call for all kinds. Every importer checks what it reads.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "firmware_like/scene/input_error.hpp"
#include "rt/describe.hpp"

namespace sortie::toolchain {

/// What to import and how strictly.
struct ImportOptions {
  std::string kind;          ///< one of import_kinds()
  std::string path;          ///< the data set's folder, or one of its files
  std::string out;           ///< LCM log to write
  bool strict{false};        ///< one bad row is an error
  double max_bad_rows{0.2};  ///< share of bad sensor rows that is an error even without `strict`
  std::ostream* notes{};     ///< where the line of each dropped row is printed; null = std::cerr
  bool no_poses{false};      ///< rls alone: scans without their poses, which become truth
  double max_range_m{0.0};   ///< carmen alone: a reading from here on is no return; 0: see there
};

/// What became of the readings or points of all scans that were used. in = used + all others.
struct ReturnCounts {
  std::uint64_t in{};
  std::uint64_t used{};
  std::uint64_t no_return{};      ///< said to be none (legal): NaN in a sweep
  std::uint64_t out_of_range{};   ///< not above 0, or at or beyond the laser's range
  std::uint64_t not_finite{};     ///< NaN or infinite where there is no word for "no return"
  std::uint64_t time_negative{};  ///< a point's time before the first point's
  std::uint64_t time_unsorted{};  ///< before that of the point before it in its row
  std::uint64_t time_beyond{};    ///< after the end of the lidar's turn
  SORTIE_FIELDS(in, used, no_return, out_of_range, not_finite, time_negative, time_unsorted, time_beyond)

  /// Adds those of one scan.
  void add(const ReturnCounts& scan);
};

/// What was imported.
struct ImportReport {
  std::uint64_t rows{};            ///< rows, records or scans read, of sensors and truth
  std::uint64_t events{};          ///< events written
  std::uint64_t bad_rows{};        ///< sensor rows dropped: not a number, not finite, too few columns
  std::uint64_t hidden_truth{};    ///< truth rows without a usable reference (legal)
  std::uint64_t time_backwards{};  ///< sensor rows whose stamp lies before the row above: kept
  std::uint64_t out_of_order{};    ///< carmen: outside the longest run of their kind that never falls
  std::uint64_t other_rows{};      ///< whole rows of kinds that the importer has no use for (legal)
  std::uint64_t imu{}, tracks{}, scans{}, truth{};  ///< events by kind
  ReturnCounts returns;                             ///< of the kinds that look at them: carmen and swp
  std::vector<std::string> sources;                 ///< files read
  std::vector<std::string> warnings;                ///< truncated tails, gaps, missing truth
  SORTIE_FIELDS(rows, events, bad_rows, hidden_truth, time_backwards, out_of_order, other_rows, imu, tracks,
                scans, truth)
};

/// Imports `options.path` and writes `options.out` (written to a temporary name first, so a failed import
/// leaves no half log). Throws InputError with exit code 3 where the data cannot be used, 2 for an unknown
/// kind or an option that the kind does not have.
ImportReport import_log(const ImportOptions& options);

/// The kinds that import_log knows, for help texts.
std::vector<std::string> import_kinds();

}  // namespace sortie::toolchain
