// SPDX-License-Identifier: BSD-3-Clause
// Statistics of channels, as a table and as JSON.
#include "toolchain/commands/spy_table.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "drivers/channels.hpp"
#include "drivers/wire_cursor.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/commands/spy_values.hpp"

namespace sortie::toolchain {
namespace {

constexpr std::size_t kWidth = 100;
constexpr std::size_t kMostChannelName = 30;

struct Column {
  const char* title;
  std::size_t width;
};
constexpr Column kColumns[] = {{"Hz", 9},    {"jitter ms", 10}, {"max gap ms", 11},
                               {"bytes", 8}, {"age s", 8},      {"count", 9}};

// Whole numbers (stamps, counts) in full, as far as a double holds them exactly.
std::string format_value(double value) {
  constexpr double kExact = 9007199254740992.0;
  const bool whole = value > -kExact && value < kExact && std::floor(value) == value;
  return whole ? firmware::format_fixed(value, 0) : firmware::format_short(value);
}

// Everything but printable ASCII replaced.
std::string printable(std::string_view text) {
  std::string shown(text);
  for (char& character : shown) {
    if (character < ' ' || character > '~') character = '?';
  }
  return shown;
}

// Values of one channel, as many to a line as fit.
void print_values(std::vector<std::string>& lines, const ChannelStatistics& statistics) {
  std::string line;
  for (const drivers::NamedValue& entry : statistics.values) {
    const std::string piece = printable(entry.name) + "=" + format_value(entry.value);
    if (!line.empty() && line.size() + 2 + piece.size() > kWidth) {
      lines.push_back(line);
      line.clear();
    }
    line += (line.empty() ? "    " : "  ") + piece;
  }
  if (!line.empty()) lines.push_back(line);
}

}  // namespace

double ChannelStatistics::rate_hz() const {
  const double span = rt::to_seconds(last_ns - first_ns);
  return count > 1 && span > 0 ? static_cast<double>(count - 1) / span : 0;
}

double ChannelStatistics::jitter_s() const {
  return count > 2 ? std::sqrt(interval_square_sum / static_cast<double>(count - 2)) : 0;
}

void SpyTable::add(std::string_view channel, std::span<const std::uint8_t> message,
                   rt::Nanoseconds stamp_ns) {
  auto found = channels_.find(channel);
  if (found == channels_.end()) {
    if (channels_.size() == kMaxChannels) {
      ++dropped_;
      return;
    }
    found = channels_.emplace(channel, ChannelStatistics{}).first;
    found->second.first_ns = stamp_ns;
  }
  ChannelStatistics& row = found->second;
  if (row.count != 0) {
    // Welford's running mean and variance. A clock that is set back counts as no time.
    const rt::Nanoseconds gap = std::max<rt::Nanoseconds>(0, stamp_ns - row.last_ns);
    row.max_gap_ns = std::max(row.max_gap_ns, gap);
    const double interval = rt::to_seconds(gap);
    const double deviation = interval - row.interval_mean_s;
    row.interval_mean_s += deviation / static_cast<double>(row.count);
    row.interval_square_sum += deviation * (interval - row.interval_mean_s);
  }
  ++row.count;
  row.bytes += message.size();
  row.last_bytes = message.size();
  row.last_ns = stamp_ns;
  row.fingerprint = drivers::fingerprint_of(message);
  std::vector<drivers::NamedValue> values;
  const Status status = read_values(message, values);
  if (status != Status::ok && status != Status::not_supported) ++row.undecodable;
  if (status == Status::ok && with_values_) row.values = std::move(values);
}

std::string shown_type(std::uint64_t fingerprint) {
  const std::string_view name = drivers::type_name(fingerprint);
  return name.empty() ? "0x" + firmware::hex(fingerprint) : std::string(name);
}

void SpyTable::print(std::ostream& out, rt::Nanoseconds now_ns, std::size_t rows) const {
  std::size_t name_width = 7;
  std::size_t type_width = 4;
  for (const auto& [name, row] : channels_) {
    name_width = std::max(name_width, std::min(name.size(), kMostChannelName));
    type_width = std::max(type_width, shown_type(row.fingerprint).size());
  }
  std::vector<std::string> lines;
  std::string head =
      firmware::pad_right("channel", name_width) + "  " + firmware::pad_right("type", type_width);
  for (const Column& column : kColumns) head += firmware::pad_left(column.title, column.width);
  lines.push_back(head);
  for (const auto& [name, row] : channels_) {
    const std::string cells[] = {
        firmware::format_short(row.rate_hz()),
        firmware::format_short(1e3 * row.jitter_s()),
        firmware::format_short(1e3 * rt::to_seconds(row.max_gap_ns)),
        std::to_string(row.last_bytes),
        firmware::format_fixed(rt::to_seconds(std::max<rt::Nanoseconds>(0, now_ns - row.last_ns)), 1),
        std::to_string(row.count)};
    std::string line = firmware::pad_right(firmware::shorten(printable(name), name_width), name_width) +
                       "  " + firmware::pad_right(shown_type(row.fingerprint), type_width);
    for (std::size_t i = 0; i < std::size(cells); ++i)
      line += firmware::pad_left(cells[i], kColumns[i].width);
    if (row.undecodable != 0) line += "  " + std::to_string(row.undecodable) + " undecodable";
    lines.push_back(line);
    print_values(lines, row);
  }
  const bool cut = rows != 0 && lines.size() > rows;
  const std::size_t shown = cut ? rows - 1 : lines.size();
  for (std::size_t i = 0; i < shown; ++i) out << lines[i] << '\n';
  if (cut) out << "... " << lines.size() - shown << " more lines\n";
}

firmware::Json SpyTable::to_json(rt::Nanoseconds now_ns) const {
  firmware::Json list = firmware::Json::array();
  for (const auto& [name, row] : channels_) {
    firmware::Json object{{"channel", printable(name)},
                          {"type", std::string(drivers::type_name(row.fingerprint))},
                          {"fingerprint", "0x" + firmware::hex(row.fingerprint)},
                          {"count", row.count},
                          {"hz", row.rate_hz()},
                          {"jitter_ms", 1e3 * row.jitter_s()},
                          {"max_gap_ms", 1e3 * rt::to_seconds(row.max_gap_ns)},
                          {"bytes", row.bytes},
                          {"last_bytes", row.last_bytes},
                          {"age_s", rt::to_seconds(now_ns - row.last_ns)},
                          {"undecodable", row.undecodable}};
    if (with_values_) {
      firmware::Json values = firmware::Json::object();
      for (const drivers::NamedValue& entry : row.values) {
        values[printable(entry.name)] = std::isfinite(entry.value) ? firmware::Json(entry.value) : nullptr;
      }
      object["values"] = std::move(values);
    }
    list.push_back(std::move(object));
  }
  return list;
}

}  // namespace sortie::toolchain
