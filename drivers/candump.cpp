// SPDX-License-Identifier: BSD-3-Clause
// candump log files: the file around the lines.
#include "drivers/candump.hpp"

#include <cerrno>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace sortie::drivers {

namespace {

std::string system_text(int error) { return std::generic_category().message(error); }

}  // namespace

CandumpReader::CandumpReader(const std::string& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw std::runtime_error(path + ": is a folder; give the candump log in it");
  }
  errno = 0;
  file_.open(path, std::ios::in | std::ios::binary);
  if (!file_) {
    throw std::runtime_error(path + ": cannot be opened (" + system_text(errno) +
                             "); check the path, or record one with candump -l can0");
  }
}

Status CandumpReader::fail(const CandumpFault& fault) {
  ++problems_;
  problem_ = path_ + ", line " + std::to_string(line_) + ": " + fault.reason + "; " + fault.cure;
  return Status::malformed;
}

Status CandumpReader::next(CandumpRecord& record) { return next_of(record); }
Status CandumpReader::next(CandumpFdRecord& record) { return next_of(record); }

template <class Record>
Status CandumpReader::next_of(Record& record) {
  char text[kCandumpFdMaxLine + 2];
  for (;;) {
    file_.getline(text, sizeof text);
    const auto taken = static_cast<std::size_t>(file_.gcount());
    if (file_.bad()) {
      ++line_;
      return fail({"the file could not be read on", "check the disk; all lines before this one were read"});
    }
    if (taken == 0) return Status::empty;
    ++line_;
    if (file_.eof()) {
      return fail(
          {"the last line has no line end", "it may have been cut off; if it is whole, end it with Enter"});
    }
    if (file_.fail()) {  // the line is longer than the buffer
      file_.clear();
      file_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      return fail(
          {"the line is longer than 191 characters", "is this a candump log? they are made by candump -l"});
    }
    const std::string_view line(text, taken - 1);
    if (line.empty() || line == "\r") continue;
    CandumpFault fault;
    if (parse_candump_line(line, record, fault) != Status::ok) return fail(fault);
    ++frames_;
    return Status::ok;
  }
}

CandumpWriter::CandumpWriter(const std::string& path, CandumpDigits digits) : digits_(digits) {
  errno = 0;
  file_.open(path, std::ios::out | std::ios::binary | std::ios::trunc);
  if (!file_) {
    throw std::runtime_error(path + ": cannot be written (" + system_text(errno) +
                             "); check that the folder exists and is yours");
  }
}

Status CandumpWriter::write(const CanFrame& frame, std::string_view interface) {
  return write(widened(frame), interface);
}

Status CandumpWriter::write(const CanFdFrame& frame, std::string_view interface) {
  char text[kCandumpFdMaxLine + 1];
  const std::size_t length =
      format_candump_line(frame, interface, digits_, std::span<char>(text, kCandumpFdMaxLine));
  if (length == 0) return Status::malformed;
  text[length] = '\n';
  if (!file_.write(text, static_cast<std::streamsize>(length + 1))) return Status::full;
  ++frames_;
  return Status::ok;
}

Status CandumpWriter::close() {
  if (!file_.is_open()) return Status::ok;
  file_.close();
  return file_ ? Status::ok : Status::full;
}

}  // namespace sortie::drivers
