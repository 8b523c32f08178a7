// SPDX-License-Identifier: BSD-3-Clause
// The file of keyframes beside a log: the whole state at some ticks, so that a replay can start there.
//
// Little endian, fixed widths; any processor reads what any other wrote:
//   "SORTIEKF", u32 format, u32 bytes of the head, u64 its xxhash64, the head
//   for each keyframe: u64 tick, u64 bytes, u64 xxhash64 of these, u64 xxhash64 of the three, the state
//   "SORTIEND", u64 number of keyframes
// A text is u32 length and its bytes.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "rt/archive.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// What keyframes belong to: a log, and the run whose state they hold.
struct KeyframeHead {
  std::string version;  ///< of the program
  std::string vehicle;
  std::uint64_t scene_hash{};  ///< of the profile with its overrides
  std::uint64_t log_bytes{};
  std::uint64_t log_events{};
  std::uint64_t log_header_digest{};  ///< of the log's SORTIE_HEADER event
  std::int64_t base_tick_ns{};
  std::string groups;  ///< tables as in the log's header
  std::string tasks;

  /// To bytes and back.
  void archive(rt::Archive& archive);
};

/// Where a keyframe lies.
struct KeyframeEntry {
  rt::Tick tick{};
  std::uint64_t bytes{};
  std::uint64_t digest{};
  std::uint64_t offset{};  ///< of the state, in the file
};

/// Writes a file of keyframes; it appears under its name only when it is whole. Set-up code.
class KeyframeWriter {
 public:
  /// Throws InputError when the file cannot be made.
  KeyframeWriter(const std::string& path, KeyframeHead head);
  ~KeyframeWriter();
  KeyframeWriter(const KeyframeWriter&) = delete;
  KeyframeWriter& operator=(const KeyframeWriter&) = delete;

  /// Adds the state before the jobs of `tick`; ticks rise. Throws InputError when it cannot be written.
  void add(rt::Tick tick, const std::vector<std::uint8_t>& state);
  /// Gives the file its name. Without it nothing is left behind. Throws InputError.
  void finish();

  const std::vector<KeyframeEntry>& entries() const { return entries_; }
  std::uint64_t bytes() const { return bytes_; }

 private:
  void write(const std::vector<std::uint8_t>& bytes);
  void remove_part();

  std::string path_;
  std::string part_;  // of a device: path_, which is written directly
  std::ofstream out_;
  std::uint64_t bytes_{};
  std::vector<KeyframeEntry> entries_;
};

/// A file of keyframes, opened. Memory: 32 bytes a keyframe; a state is read when it is asked for.
class KeyframeFile {
 public:
  /// Throws InputError (place, fault, cure) when the file is missing, none of keyframes, cut off or damaged.
  explicit KeyframeFile(const std::string& path);

  const std::string& path() const { return path_; }
  const KeyframeHead& head() const { return head_; }
  const std::vector<KeyframeEntry>& entries() const { return entries_; }
  /// The last keyframe at or before `tick`, or null.
  const KeyframeEntry* nearest(rt::Tick tick) const;
  /// The state of a keyframe, its hash compared. Throws InputError.
  std::vector<std::uint8_t> state(const KeyframeEntry& entry) const;

 private:
  std::string path_;
  KeyframeHead head_;
  std::vector<KeyframeEntry> entries_;
};

/// Where keyframes of a log lie unless told otherwise.
inline std::string keyframe_path(const std::string& log_path) { return log_path + ".keyframes"; }

}  // namespace sortie::firmware
