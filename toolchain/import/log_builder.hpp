// SPDX-License-Identifier: BSD-3-Clause
// Collects samples in any order and writes them as an LCM log in order of receipt.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "drivers/wire_records.hpp"
#include "rt/samples.hpp"
#include "toolchain/import/importer.hpp"

namespace sortie::toolchain {

/// Samples of one import. Memory: all samples at once; a data set is read to its end before anything is
/// written.
class LogBuilder {
 public:
  struct Scan {
    rt::ScanHeader header;
    std::vector<rt::ScanPoint> points;
  };
  using Sample = std::variant<rt::ImuSample, rt::TrackSample, rt::TruthSample, Scan>;

  /// Adds a sample that was received at `receipt_ns`. Equal receipts keep the order of the calls.
  void add(rt::Nanoseconds receipt_ns, Sample sample);
  /// `header.points` is taken from `points`.
  void add(rt::Nanoseconds receipt_ns, const rt::ScanHeader& header, std::vector<rt::ScanPoint> points);

  /// The pose at which the log begins; the identity unless set.
  void set_initial_pose(const double (&p)[3], const double (&q)[4]);

  /// Writes SORTIE_HEADER and all events to `path`; counts them in `report`. Receipts are rounded up to whole
  /// microseconds, so that no sample is received before its own stamp. The file appears under its name only
  /// when it is whole. Throws InputError (file, reason) if it cannot be written, or if there is no sample at
  /// all.
  void write(const std::string& path, const std::string& kind, ImportReport& report) const;

 private:
  struct Entry {
    std::int64_t receipt_us;
    Sample sample;
  };

  std::vector<Entry> entries_;
  double initial_p_[3]{};
  double initial_q_[4]{1, 0, 0, 0};
};

}  // namespace sortie::toolchain
