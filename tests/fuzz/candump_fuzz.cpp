// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any text goes through the candump line parser. What it takes must be a frame that
// can be written and read again unchanged; what it refuses must come with a reason and a cure.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "drivers/candump.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

template <class Record>
void check_line(std::string_view line) {
  Record record;
  CandumpFault fault;
  if (parse_candump_line(line, record, fault) != Status::ok) {
    require(fault.reason[0] != '\0' && fault.cure[0] != '\0');
    return;
  }
  char text[kCandumpFdMaxLine];
  const std::size_t length = format_candump_line(record.frame, record.interface, CandumpDigits::nano, text);
  require(length > 0);
  Record again;
  require(parse_candump_line(std::string_view(text, length), again, fault) == Status::ok);
  require(again.frame.stamp_ns == record.frame.stamp_ns && again.frame.id == record.frame.id);
  require(again.frame.flags == record.frame.flags && again.frame.size == record.frame.size);
  require(std::memcmp(again.frame.data, record.frame.data, sizeof record.frame.data) == 0);
  require(std::strcmp(again.interface, record.interface) == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    check_line<CandumpRecord>(text.substr(0, end));
    check_line<CandumpFdRecord>(text.substr(0, end));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return 0;
}
