// SPDX-License-Identifier: BSD-3-Clause
// A whole log, indexed: which samples each channel holds, which jobs each group ran, where it breaks off.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"
#include "drivers/wire_records.hpp"
#include "firmware_like/log/timed_pose.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// One event of a channel; the bytes live as long as the LogFile.
struct StoredEvent {
  std::int64_t timestamp_us{};
  std::span<const std::uint8_t> message;
};

/// An LCM log of this program, live or imported, mapped into memory. Cost of opening: one pass over the event
/// headers; memory 24 bytes an event.
class LogFile {
 public:
  /// Throws InputError (exit code 3) when the file is missing, is no LCM log, or has no SORTIE_HEADER. A log
  /// that is cut off or damaged opens with all complete events before the damage; problems() tells.
  explicit LogFile(const std::string& path);

  const std::string& path() const { return path_; }
  const drivers::LogHeader& header() const { return header_; }
  /// Events of a channel in file order; empty for a channel that is not there.
  const std::vector<StoredEvent>& channel(const std::string& name) const;
  const std::map<std::string, std::vector<StoredEvent>>& channels() const { return channels_; }
  std::uint64_t events() const { return events_; }
  std::uint64_t bytes() const { return reader_.size_bytes(); }
  /// One line each: where the file is damaged, where the recorder had lost something.
  const std::vector<std::string>& problems() const { return problems_; }
  /// Empty, or one line: the byte at which the file is cut off or damaged, and what was kept.
  const std::string& damage() const { return damage_; }
  /// First tick that a recorder's gap may have touched, or the largest tick.
  rt::Tick whole_until() const { return whole_until_; }
  /// Reference poses, tidy; empty if the log has none.
  Trajectory truth() const;
  /// Receipt time of the first and the last event that is a sample, ns.
  rt::Nanoseconds first_sample_ns() const { return first_sample_ns_; }
  rt::Nanoseconds last_sample_ns() const { return last_sample_ns_; }

 private:
  std::string path_;
  drivers::LcmLogReader reader_;
  drivers::LogHeader header_;
  std::map<std::string, std::vector<StoredEvent>> channels_;
  std::vector<std::string> problems_;
  std::string damage_;
  std::uint64_t events_{};
  rt::Tick whole_until_{~rt::Tick{0}};
  rt::Nanoseconds first_sample_ns_{};
  rt::Nanoseconds last_sample_ns_{};
};

}  // namespace sortie::firmware
