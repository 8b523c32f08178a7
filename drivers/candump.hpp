// SPDX-License-Identifier: BSD-3-Clause
// candump log files, as can-utils writes and plays them: (1408129200.042000) can0 0DF805A0#002B87A93FFCEDC4
// Not for the real-time path: these read and write files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "drivers/can_bus.hpp"
#include "drivers/can_fd.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// One line of a log.
struct CandumpRecord {
  CanFrame frame{};
  char interface[16]{};  ///< name of the CAN interface, ends with a zero
};

/// The same for a log that may hold CAN FD frames.
struct CandumpFdRecord {
  CanFdFrame frame{};
  char interface[16]{};
};

/// What is wrong with a line: both are static texts.
struct CandumpFault {
  const char* reason = "";
  const char* cure = "";
};

/// Decimals of the time in a written log. canplayer of older can-utils reads micro only.
enum class CandumpDigits : std::uint8_t { micro = 6, nano = 9 };

/// Longest line that is written for a classical frame, without its line end.
inline constexpr std::size_t kCandumpMaxLine = 127;

/// The same for an FD frame, and the longest line that is read.
inline constexpr std::size_t kCandumpFdMaxLine = 191;

/// Reads one line without its line end: standard (3 hex digits) and extended (8) identifiers, remote frames
/// (#R, #R4), error frames (identifier with bit 29), times with 6 or 9 decimals, a trailing R or T
/// (direction). Status: ok, malformed (`fault` says why; `record` is unchanged). No heap.
[[nodiscard]] Status parse_candump_line(std::string_view line, CandumpRecord& record,
                                        CandumpFault& fault) noexcept;

/// Writes one line without line end into `out` (kCandumpMaxLine + 1 bytes are always enough) and returns its
/// length; 0 if the frame cannot be written: stamp before 1970, size > 8, identifier too wide, undefined
/// flags, interface name empty, longer than 15 or with spaces. Finer time than the digits show is cut off. No
/// heap.
std::size_t format_candump_line(const CanFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept;

/// The same for frames of both kinds: an FD frame has two # and a hexadecimal digit of flags (1: bit rate
/// switch, 2: error state) before its data, 123##1001122. A size that no FD frame has is malformed.
[[nodiscard]] Status parse_candump_line(std::string_view line, CandumpFdRecord& record,
                                        CandumpFault& fault) noexcept;
std::size_t format_candump_line(const CanFdFrame& frame, std::string_view interface, CandumpDigits digits,
                                std::span<char> out) noexcept;

/// A log file, read line by line. A damaged line is reported and does not end the log.
class CandumpReader {
 public:
  /// Throws std::runtime_error (path, reason, cure) if the file cannot be read.
  explicit CandumpReader(const std::string& path);

  /// The next frame; empty lines are passed over. Status: ok; empty (end of the log); malformed (see
  /// problem(); the next call goes on with the next line).
  [[nodiscard]] Status next(CandumpRecord& record);
  /// The same for a log that may hold CAN FD frames.
  [[nodiscard]] Status next(CandumpFdRecord& record);

  /// The latest damage in one line: path, line number, reason, cure.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }
  /// Number of the line read last, from 1.
  [[nodiscard]] std::uint64_t line() const noexcept { return line_; }
  /// Good frames given so far.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// Damaged lines met so far.
  [[nodiscard]] std::uint64_t problems() const noexcept { return problems_; }

 private:
  Status fail(const CandumpFault& fault);
  template <class Record>
  Status next_of(Record& record);

  std::string path_;
  std::ifstream file_;
  std::string problem_;
  std::uint64_t line_{};
  std::uint64_t frames_{};
  std::uint64_t problems_{};
};

/// Writes a log file.
class CandumpWriter {
 public:
  /// Creates or replaces the file. Throws std::runtime_error (path, reason, cure) if it cannot.
  explicit CandumpWriter(const std::string& path, CandumpDigits digits = CandumpDigits::micro);

  /// Appends one frame. Status: ok; malformed (not a frame that a log can hold; nothing written); full (the
  /// file cannot be written on).
  [[nodiscard]] Status write(const CanFrame& frame, std::string_view interface = "can0");
  /// The same for a frame of either kind.
  [[nodiscard]] Status write(const CanFdFrame& frame, std::string_view interface = "can0");
  /// Ends the file. Status: ok; full (not everything could be written).
  [[nodiscard]] Status close();
  /// Frames written so far.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }

 private:
  std::ofstream file_;
  CandumpDigits digits_;
  std::uint64_t frames_{};
};

}  // namespace sortie::drivers
