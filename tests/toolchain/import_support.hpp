// SPDX-License-Identifier: BSD-3-Clause
// Running an importer in a test and reading its log back whole.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_records.hpp"
#include "tests/firmware_like/temp_folder.hpp"
#include "toolchain/import/importer.hpp"

namespace sortie::testing {

using firmware::InputError;
using toolchain::ImportOptions;
using toolchain::ImportReport;

/// A log read back whole.
struct Log {
  drivers::LogHeader header;
  std::vector<rt::ImuSample> imu;
  std::vector<rt::TrackSample> tracks;
  std::vector<rt::TruthSample> truth;
  std::vector<rt::ScanHeader> scans;
  std::vector<std::vector<rt::ScanPoint>> points;
  std::vector<std::int64_t> receipts_us;
  bool seqs_count_from_zero{true};
};

inline Log read_log(const std::string& path) {
  Log log;
  drivers::LcmLogReader reader(path);
  drivers::LogEvent event;
  while (reader.next(event) == Status::ok) {
    log.receipts_us.push_back(event.timestamp_us);
    std::int64_t seq = -1;
    if (event.channel == "SORTIE_HEADER") {
      REQUIRE(log.receipts_us.size() == 1);
      REQUIRE(drivers::decode(event.data, log.header) == Status::ok);
    } else if (event.channel == "IMU") {
      REQUIRE(drivers::decode(event.data, log.imu.emplace_back(), seq) == Status::ok);
      log.seqs_count_from_zero &= seq == static_cast<std::int64_t>(log.imu.size()) - 1;
    } else if (event.channel == "TRACK") {
      REQUIRE(drivers::decode(event.data, log.tracks.emplace_back(), seq) == Status::ok);
      log.seqs_count_from_zero &= seq == static_cast<std::int64_t>(log.tracks.size()) - 1;
    } else if (event.channel == "TRUTH") {
      REQUIRE(drivers::decode(event.data, log.truth.emplace_back()) == Status::ok);
    } else if (event.channel == "SCAN") {
      auto& points = log.points.emplace_back(100000);
      REQUIRE(drivers::decode(event.data, log.scans.emplace_back(), points, seq) == Status::ok);
      points.resize(log.scans.back().points);
      log.seqs_count_from_zero &= seq == static_cast<std::int64_t>(log.scans.size()) - 1;
    } else {
      FAIL("unexpected channel " << event.channel);
    }
  }
  CHECK(reader.problem_count() == 0);
  return log;
}

/// What an import said.
struct Outcome {
  ImportReport report;
  std::string notes;
  std::string error;
  int exit_code{};
};

/// Imports; an error becomes part of the outcome, and must have left no file behind.
inline Outcome run(const std::string& kind, const std::string& path, const std::string& out,
                   bool strict = false) {
  std::ostringstream notes;
  ImportOptions options{kind, path, out};
  options.strict = strict;
  options.notes = &notes;
  Outcome outcome;
  try {
    outcome.report = import_log(options);
  } catch (const InputError& error) {
    outcome.error = error.what();
    outcome.exit_code = error.exit_code();
    CHECK(outcome.error.find('\n') == std::string::npos);
    CHECK_FALSE(std::filesystem::exists(out));
    CHECK_FALSE(std::filesystem::exists(out + ".part"));
  }
  outcome.notes = notes.str();
  return outcome;
}

}  // namespace sortie::testing
