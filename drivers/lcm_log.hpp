// SPDX-License-Identifier: BSD-3-Clause
// The LCM event log: what lcm-logger writes and lcm-logplayer plays. Own reader and writer, because a flight
// recorder must say where a damaged log broke, keep all that came before, and report a full disk.
//
// Form of an event, big endian: u32 0xEDA1DA01, i64 number, i64 timestamp_us, u32 channel bytes, u32 data
// bytes, channel (no zero at its end), data. No file header, no index.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "rt/status.hpp"

namespace sortie::drivers {

inline constexpr std::uint32_t kLcmLogSync = 0xEDA1DA01u;
inline constexpr std::size_t kLcmLogHeaderBytes = 28;
/// Largest message that LCM carries. More in a log is a damaged length.
inline constexpr std::uint32_t kLcmLogMaxData = 1u << 28;
/// liblcm's own reader takes channel names below this.
inline constexpr std::uint32_t kLcmLogMaxChannel = 1000;

/// One event of a log. The views live as long as the bytes that were read.
struct LogEvent {
  std::int64_t number{};
  std::int64_t timestamp_us{};
  std::string_view channel;
  std::span<const std::uint8_t> data;
  std::uint64_t offset{};  ///< of the event's first byte in the log
};

/// Where and why a log could not be read on.
struct LogProblem {
  std::uint64_t offset{};   ///< byte offset of the event that is damaged
  std::uint64_t event{};    ///< complete events before it
  std::uint64_t skipped{};  ///< bytes from there to the end
  const char* reason = "";  ///< static text

  /// One line: "byte 1234: the last event is cut off (after 17 complete events, 40 bytes dropped)".
  [[nodiscard]] std::string describe() const;
};

/// Whether these bytes (not none), as far as they go, are the first of an event.
[[nodiscard]] bool begin_an_event(std::span<const std::uint8_t> bytes) noexcept;

/// Walks the events of a log that lies in memory. No heap, no exception; never reads outside `bytes`,
/// whatever they hold.
class LcmLogCursor {
 public:
  explicit LcmLogCursor(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Gives the next complete event. `empty`: clean end. `malformed`: damaged here, see problem(); each
  /// further call says the same. Cost: constant; linear in the bytes of a damaged rest.
  [[nodiscard]] Status next(LogEvent& event) noexcept;
  /// The damage; meaningful once next() gave `malformed`.
  [[nodiscard]] const LogProblem& problem() const noexcept { return problem_; }
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }
  /// Byte offset of the next event.
  [[nodiscard]] std::uint64_t position() const noexcept { return position_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_{};
  std::uint64_t events_{};
  LogProblem problem_{};
};

/// A log file, mapped read-only. Its length is fixed when it is opened: a log that still grows can be read,
/// one that is shortened meanwhile cannot. On 32-bit systems logs above some 2 GB are refused.
class LcmLogReader {
 public:
  /// Throws std::runtime_error (path, what is wrong, cure) if the file is missing, unreadable, a directory,
  /// or does not begin like an LCM log. An empty file is a log without events.
  explicit LcmLogReader(const std::string& path);
  ~LcmLogReader();
  LcmLogReader(const LcmLogReader&) = delete;
  LcmLogReader& operator=(const LcmLogReader&) = delete;

  /// As LcmLogCursor::next(). The event's views live as long as the reader.
  [[nodiscard]] Status next(LogEvent& event) noexcept { return cursor_.next(event); }
  [[nodiscard]] const LogProblem& problem() const noexcept { return cursor_.problem(); }
  /// Complete events given so far.
  [[nodiscard]] std::uint64_t events() const noexcept { return cursor_.events(); }
  [[nodiscard]] std::uint64_t size_bytes() const noexcept { return bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  LcmLogCursor cursor_;
};

/// Writes a log through a buffer of its own. For a thread that may block on a disk.
class LcmLogWriter {
 public:
  /// Creates or replaces the file. Throws std::runtime_error (path, system's reason, cure) if it cannot.
  explicit LcmLogWriter(const std::string& path, std::size_t buffer_bytes = std::size_t{1} << 20);
  /// Writes to a file that is open and empty; `descriptor` becomes the writer's, who closes it. `path`: what
  /// errors call it.
  LcmLogWriter(int descriptor, const std::string& path, std::size_t buffer_bytes = std::size_t{1} << 20);
  /// Writes what is left; errors are lost here, so call close() where they matter.
  ~LcmLogWriter();
  LcmLogWriter(const LcmLogWriter&) = delete;
  LcmLogWriter& operator=(const LcmLogWriter&) = delete;

  /// Appends one event; numbers count from 0. `malformed`: channel empty, longer than 63 bytes or with a zero
  /// in it, or data beyond kLcmLogMaxData; nothing is written. `full`: no room on the disk; `disconnected`:
  /// any other error of the file. After one of these the file is cut back to its last complete event, error()
  /// says what happened, and every further append is refused and counted. Cost: a copy, sometimes one
  /// write().
  [[nodiscard]] Status append(std::string_view channel, std::int64_t timestamp_us,
                              std::span<const std::uint8_t> data);
  /// After append() has failed: one event more, of up to kLastBytes with its head, so that the log itself
  /// says that it is not whole. The last complete events before the failure gave way for it. Status as
  /// append(); `full` when there was no such room.
  [[nodiscard]] Status append_last(std::string_view channel, std::int64_t timestamp_us,
                                   std::span<const std::uint8_t> data);
  static constexpr std::size_t kLastBytes = 512;
  /// Hands everything to the operating system (not to the disk). Status as append().
  [[nodiscard]] Status flush();
  /// flush(), and asks the operating system to begin writing to the disk, without waiting for it: so a power
  /// cut takes seconds of the log, not half a minute. Status as append().
  [[nodiscard]] Status start_writeback();
  /// flush() and close; also reports what the system says only then. Further appends are refused. Idempotent.
  [[nodiscard]] Status close();

  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }  ///< accepted
  [[nodiscard]] std::uint64_t refused() const noexcept {
    return refused_;
  }  ///< appends refused after an error
  /// Events that were accepted into the buffer and then could not be written.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return file_bytes_ + used_; }
  /// Empty, or one line: path, what the system said, how many events are safe.
  [[nodiscard]] const std::string& error() const noexcept { return error_; }

 private:
  Status fail(int system_error);

  std::string path_;
  int fd_{-1};
  std::unique_ptr<std::uint8_t[]> buffer_;
  std::size_t capacity_;
  std::size_t used_{};
  std::uint64_t file_bytes_{};
  std::uint64_t events_{};
  std::uint64_t refused_{};
  std::uint64_t lost_{};
  Status status_{Status::ok};
  std::string error_;
};

}  // namespace sortie::drivers
