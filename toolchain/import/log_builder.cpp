// SPDX-License-Identifier: BSD-3-Clause
// Sorts by receipt, numbers each channel from 0, and writes through the drivers' log writer.
#include "toolchain/import/log_builder.hpp"

#include <algorithm>
#include <filesystem>

#include "drivers/lcm_log.hpp"
#include "drivers/wire.hpp"
#include "firmware_like/result/results.hpp"
#include "rt/posix/file_place.hpp"

namespace sortie::toolchain {
namespace {

/// Changes when an importer gives other samples for the same files.
constexpr const char* kImporterVersion = "importer 1";

std::int64_t ceil_us(rt::Nanoseconds ns) {
  const std::int64_t us = ns / rt::kNanosecondsPerMicrosecond;
  return ns > us * rt::kNanosecondsPerMicrosecond ? us + 1 : us;
}

/// A log that is written beside its name and gets it only when it is whole (rt/posix/file_place.hpp).
class OutputLog {
 public:
  explicit OutputLog(const std::string& path) try
      : place_(path), writer_(place_.second_descriptor(), place_.path()) {
  } catch (const std::runtime_error& error) {
    throw firmware::InputError(error.what());
  }
  OutputLog(const OutputLog&) = delete;
  OutputLog& operator=(const OutputLog&) = delete;

  void append(std::string_view channel, std::int64_t receipt_us, std::span<const std::uint8_t> data) {
    if (writer_.append(channel, receipt_us, data) != Status::ok) fail();
  }
  void finish() {
    if (writer_.close() != Status::ok) fail();
    if (const std::string why = place_.take(rt::posix::FormerFile::replaced); !why.empty())
      throw firmware::InputError(why + "; choose another place with -o");
  }

 private:
  [[noreturn]] void fail() const {
    throw firmware::InputError(writer_.error() + "; free some space or choose another place with -o");
  }

  rt::posix::FilePlace place_;
  drivers::LcmLogWriter writer_;
};

drivers::LogHeader header_of(const std::string& kind, const std::vector<std::string>& sources) {
  drivers::LogHeader header;
  header.version = kImporterVersion;
  header.compiler = firmware::compiler_description();
  header.source = kind;
  for (const std::string& source : sources)
    header.source += " " + std::filesystem::path(source).filename().string();
  header.has_ticks = false;
  return header;
}

}  // namespace

void LogBuilder::add(rt::Nanoseconds receipt_ns, Sample sample) {
  entries_.push_back({ceil_us(receipt_ns), std::move(sample)});
}

void LogBuilder::add(rt::Nanoseconds receipt_ns, const rt::ScanHeader& header,
                     std::vector<rt::ScanPoint> points) {
  Scan scan{header, std::move(points)};
  scan.header.points = static_cast<std::uint32_t>(scan.points.size());
  add(receipt_ns, std::move(scan));
}

void LogBuilder::set_initial_pose(const double (&p)[3], const double (&q)[4]) {
  std::copy(std::begin(p), std::end(p), initial_p_);
  std::copy(std::begin(q), std::end(q), initial_q_);
}

void LogBuilder::write(const std::string& path, const std::string& kind, ImportReport& report) const {
  std::vector<const Entry*> order;
  for (const Entry& entry : entries_) order.push_back(&entry);
  std::stable_sort(order.begin(), order.end(),
                   [](const Entry* a, const Entry* b) { return a->receipt_us < b->receipt_us; });
  if (std::all_of(order.begin(), order.end(), [](const Entry* entry) {
        return std::holds_alternative<rt::TruthSample>(entry->sample);
      })) {
    throw firmware::InputError((report.sources.empty() ? path : report.sources.front()) +
                               ": holds no usable sensor sample; check that the file is whole");
  }
  drivers::LogHeader header = header_of(kind, report.sources);
  header.epoch_ns = order.front()->receipt_us * rt::kNanosecondsPerMicrosecond;
  std::copy(std::begin(initial_p_), std::end(initial_p_), header.initial_p);
  std::copy(std::begin(initial_q_), std::end(initial_q_), header.initial_q);

  OutputLog log(path);
  std::vector<std::uint8_t> buffer;
  const auto put = [&](std::string_view channel, std::int64_t us, std::size_t bytes, auto&& encode) {
    if (buffer.size() < bytes) buffer.resize(bytes);
    std::size_t size = 0;
    const Status status = encode(std::span(buffer), size);
    if (status != Status::ok)
      throw firmware::InputError(std::string(channel) + ": a sample cannot be written: " + to_string(status));
    log.append(channel, us, std::span(buffer).first(size));
  };
  const auto with_seq = [](const auto& sample, std::uint64_t& count) {
    const auto seq = static_cast<std::int64_t>(count++);
    return [&sample, seq](std::span<std::uint8_t> out, std::size_t& size) {
      return drivers::encode(sample, seq, out, size);
    };
  };
  put(drivers::kChannelHeader, order.front()->receipt_us, drivers::encoded_bytes(header),
      [&](std::span<std::uint8_t> out, std::size_t& size) { return drivers::encode(header, out, size); });
  for (const Entry* entry : order) {
    if (const auto* imu = std::get_if<rt::ImuSample>(&entry->sample)) {
      put(drivers::kChannelImu, entry->receipt_us, drivers::kImuBytes, with_seq(*imu, report.imu));
    } else if (const auto* track = std::get_if<rt::TrackSample>(&entry->sample)) {
      put(drivers::kChannelTrack, entry->receipt_us, drivers::kTrackBytes, with_seq(*track, report.tracks));
    } else if (const auto* truth = std::get_if<rt::TruthSample>(&entry->sample)) {
      ++report.truth;
      put(drivers::kChannelTruth, entry->receipt_us, drivers::kTruthBytes,
          [truth](std::span<std::uint8_t> out, std::size_t& size) {
            return drivers::encode(*truth, out, size);
          });
    } else {
      const Scan& scan = std::get<Scan>(entry->sample);
      const rt::PointScan view{scan.header, scan.points.data()};
      put(drivers::kChannelScan, entry->receipt_us, drivers::scan_bytes(scan.points.size()),
          with_seq(view, report.scans));
    }
  }
  log.finish();
  report.events = 1 + report.imu + report.tracks + report.truth + report.scans;
}

}  // namespace sortie::toolchain
