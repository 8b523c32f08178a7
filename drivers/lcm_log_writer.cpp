// SPDX-License-Identifier: BSD-3-Clause
// Writes a log through a buffer; after an error of the disk the file ends with its last complete event.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "drivers/channels.hpp"
#include "drivers/lcm_log.hpp"
#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {
namespace {

constexpr std::size_t kMinBuffer = 4096;

// Writes all of it; `written` tells how far it came. 0 or the system's error.
int write_all(int fd, std::span<const std::uint8_t> bytes, std::size_t& written) {
  written = 0;
  while (written < bytes.size()) {
    const ssize_t step = ::write(fd, bytes.data() + written, bytes.size() - written);
    if (step > 0) {
      written += static_cast<std::size_t>(step);
    } else if (step == 0) {
      return ENOSPC;
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

std::size_t write_head(std::span<std::uint8_t> out, std::uint64_t number, std::int64_t timestamp_us,
                       std::string_view channel, std::size_t data_bytes) {
  WireWriter writer(out);
  writer.put(kLcmLogSync);
  writer.put(number);
  writer.put(timestamp_us);
  writer.put(static_cast<std::uint32_t>(channel.size()));
  writer.put(static_cast<std::uint32_t>(data_bytes));
  writer.put_array(channel.data(), channel.size());
  return writer.size();
}

}  // namespace

LcmLogWriter::LcmLogWriter(const std::string& path, std::size_t buffer_bytes)
    : LcmLogWriter(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644), path, buffer_bytes) {
}

LcmLogWriter::LcmLogWriter(int descriptor, const std::string& path, std::size_t buffer_bytes)
    : path_(path), fd_(descriptor), capacity_(std::max(buffer_bytes, kMinBuffer)) {
  if (fd_ < 0) {
    throw std::runtime_error(path + ": cannot be created: " + std::strerror(errno) +
                             "; give a path in a directory that can be written");
  }
  buffer_ = std::make_unique<std::uint8_t[]>(capacity_);
}

LcmLogWriter::~LcmLogWriter() { static_cast<void>(close()); }

Status LcmLogWriter::append(std::string_view channel, std::int64_t timestamp_us,
                            std::span<const std::uint8_t> data) {
  if (status_ != Status::ok) {
    ++refused_;
    return status_;
  }
  if (channel.empty() || channel.size() > kMaxChannelLength || channel.find('\0') != std::string_view::npos ||
      data.size() > kLcmLogMaxData) {
    return Status::malformed;
  }
  const std::size_t total = kLcmLogHeaderBytes + channel.size() + data.size();
  if (total > capacity_ - used_) {
    if (const Status status = flush(); status != Status::ok) {
      ++refused_;
      return status;
    }
  }
  if (total <= capacity_) {
    used_ +=
        write_head({buffer_.get() + used_, capacity_ - used_}, events_, timestamp_us, channel, data.size());
    if (!data.empty()) std::memcpy(buffer_.get() + used_, data.data(), data.size());
    used_ += data.size();
    ++events_;
    return Status::ok;
  }
  // Larger than the buffer: straight to the file, which ends with a complete event at this point.
  std::uint8_t head[kLcmLogHeaderBytes + kMaxChannelLength];
  const std::size_t head_bytes = write_head(head, events_, timestamp_us, channel, data.size());
  std::size_t written = 0;
  int error = write_all(fd_, {head, head_bytes}, written);
  if (error == 0) error = write_all(fd_, data, written);
  if (error != 0) {
    ++refused_;
    return fail(error);
  }
  file_bytes_ += total;
  ++events_;
  return Status::ok;
}

Status LcmLogWriter::flush() {
  if (status_ != Status::ok || used_ == 0) return status_;
  std::size_t written = 0;
  const int error = write_all(fd_, {buffer_.get(), used_}, written);
  if (error == 0) {
    file_bytes_ += used_;
    used_ = 0;
    return Status::ok;
  }
  // Keep the events that are on the disk whole, but for room for a last one; count the others as lost.
  const std::size_t most = written > kLastBytes ? written - kLastBytes : 0;
  LcmLogCursor whole({buffer_.get(), written});
  LogEvent event;
  std::uint64_t kept_events = 0;
  std::uint64_t kept_bytes = 0;
  while (whole.next(event) == Status::ok && whole.position() <= most) {
    kept_events = whole.events();
    kept_bytes = whole.position();
  }
  LcmLogCursor all({buffer_.get(), used_});
  while (all.next(event) == Status::ok) {
  }
  lost_ += all.events() - kept_events;
  events_ -= all.events() - kept_events;
  file_bytes_ += kept_bytes;
  used_ = 0;
  return fail(error);
}

Status LcmLogWriter::start_writeback() {
  const Status status = flush();
#ifdef SYNC_FILE_RANGE_WRITE
  // What the file system cannot do it leaves undone.
  if (status == Status::ok && fd_ >= 0)
    static_cast<void>(::sync_file_range(fd_, 0, 0, SYNC_FILE_RANGE_WRITE));
#endif
  return status;
}

Status LcmLogWriter::append_last(std::string_view channel, std::int64_t timestamp_us,
                                 std::span<const std::uint8_t> data) {
  if (status_ == Status::ok) return append(channel, timestamp_us, data);
  const std::size_t total = kLcmLogHeaderBytes + channel.size() + data.size();
  if (fd_ < 0 || total > kLastBytes || channel.empty() || channel.size() > kMaxChannelLength) return status_;
  std::uint8_t event[kLastBytes];
  const std::size_t head = write_head(event, events_, timestamp_us, channel, data.size());
  if (!data.empty()) std::memcpy(event + head, data.data(), data.size());
  std::size_t written = 0;
  if (::lseek(fd_, static_cast<off_t>(file_bytes_), SEEK_SET) < 0 ||
      write_all(fd_, {event, total}, written) != 0) {
    static_cast<void>(::ftruncate(fd_, static_cast<off_t>(file_bytes_)));  // as it was
    return status_;
  }
  file_bytes_ += total;
  ++events_;
  return Status::ok;
}

Status LcmLogWriter::fail(int system_error) {
  const bool no_room = system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG;
  status_ = no_room ? Status::full : Status::disconnected;
  const bool cut = ::ftruncate(fd_, static_cast<off_t>(file_bytes_)) == 0;
  error_ = path_ + ": writing failed after byte " + std::to_string(file_bytes_) + ": " +
           std::strerror(system_error) + "; " + std::to_string(events_) + " events before it are " +
           (cut ? "complete" : "complete, followed by a broken one") +
           (no_room ? "; free some space or record elsewhere" : "");
  return status_;
}

Status LcmLogWriter::close() {
  if (fd_ < 0) return error_.empty() ? Status::ok : status_;
  static_cast<void>(flush());
  const int result = ::close(fd_);
  const int error = errno;
  fd_ = -1;
  if (status_ != Status::ok) return status_;
  status_ = Status::disconnected;
  if (result != 0 && error != EINTR) {
    status_ = error == ENOSPC || error == EDQUOT || error == EFBIG ? Status::full : Status::disconnected;
    error_ = path_ + ": closing failed: " + std::strerror(error) + "; the end of the log may be missing";
    return status_;
  }
  return Status::ok;
}

}  // namespace sortie::drivers
