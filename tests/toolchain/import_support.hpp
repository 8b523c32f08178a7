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
#include "rt/rotation.hpp"
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
  std::vector<rt::ScanPoint> room(131072);
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
      REQUIRE(drivers::decode(event.data, log.scans.emplace_back(), room, seq) == Status::ok);
      log.points.emplace_back(room.begin(), room.begin() + log.scans.back().points);
      log.seqs_count_from_zero &= seq == static_cast<std::int64_t>(log.scans.size()) - 1;
    } else {
      FAIL("unexpected channel " << event.channel);
    }
  }
  CHECK(reader.next(event) == Status::empty);
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
inline Outcome run(ImportOptions options) {
  std::ostringstream notes;
  options.notes = &notes;
  const std::string out = options.out;
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

inline Outcome run(const std::string& kind, const std::string& path, const std::string& out,
                   bool strict = false) {
  ImportOptions options{kind, path, out};
  options.strict = strict;
  return run(options);
}

/// Log's odometry as whoever reads it would have it, written here again: rates and travel summed up, a pose
/// for each TRACK sample, in the order of the log.
struct ReckonedPose {
  rt::Nanoseconds stamp_ns{};
  rt::Vector3 p_m;
  rt::Quaternion q;
};

inline std::vector<ReckonedPose> reckon(const Log& log) {
  std::vector<ReckonedPose> attitudes;
  rt::Quaternion q = rt::to_quaternion(log.header.initial_q);
  for (std::size_t i = 0; i < log.imu.size(); ++i) {
    const double dt = i == 0 ? 0.0 : rt::to_seconds(log.imu[i].stamp_ns - log.imu[i - 1].stamp_ns);
    q = rt::normalised(q * rt::exp_rotation(dt * rt::to_vector(log.imu[i].gyr_rad_s)));
    attitudes.push_back({log.imu[i].stamp_ns, {}, q});
  }
  const auto attitude_at = [&](rt::Nanoseconds stamp_ns) {
    std::size_t after = 0;
    std::size_t end = attitudes.size();
    while (after < end) {
      const std::size_t middle = (after + end) / 2;
      if (attitudes[middle].stamp_ns < stamp_ns) {
        after = middle + 1;
      } else {
        end = middle;
      }
    }
    if (after == 0) return attitudes.front().q;
    if (after == attitudes.size()) return attitudes.back().q;
    const ReckonedPose& a = attitudes[after - 1];
    const ReckonedPose& b = attitudes[after];
    return rt::slerp(a.q, b.q,
                     rt::to_seconds(stamp_ns - a.stamp_ns) / rt::to_seconds(b.stamp_ns - a.stamp_ns));
  };
  std::vector<ReckonedPose> poses;
  rt::Vector3 p_m = rt::to_vector(log.header.initial_p);
  for (std::size_t i = 0; i < log.tracks.size(); ++i) {
    const rt::TrackSample& now = log.tracks[i];
    if (i > 0) {
      const rt::TrackSample& before = log.tracks[i - 1];
      const double way_m = 0.5 * (now.left_m + now.right_m - before.left_m - before.right_m);
      p_m = p_m + way_m * rt::rotate(attitude_at((now.stamp_ns + before.stamp_ns) / 2), {1, 0, 0});
    }
    poses.push_back({now.stamp_ns, p_m, attitude_at(now.stamp_ns)});
  }
  return poses;
}

}  // namespace sortie::testing
