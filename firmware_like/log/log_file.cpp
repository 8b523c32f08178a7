// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/log_file.hpp"

#include <algorithm>
#include <filesystem>

#include "drivers/wire.hpp"
#include "firmware_like/scene/input_error.hpp"

namespace sortie::firmware {

namespace {

// Beyond it, times in ns do not fit and their differences overflow.
constexpr std::int64_t kFarthestUs = (std::int64_t{1} << 62) / 1000;

// The reader's own messages are for set-up code; here they become the exception that ends a command with
// code 3.
const std::string& checked(const std::string& path) {
  if (std::filesystem::is_directory(path)) {
    throw InputError(path + ": is a folder, not a log; import data sets with `sortie import KIND " + path +
                     " -o LOG`");
  }
  try {
    const drivers::LcmLogReader probe(path);
  } catch (const std::exception& error) {
    throw InputError(error.what());
  }
  return path;
}

}  // namespace

LogFile::LogFile(const std::string& path) : path_(path), reader_(checked(path)) {
  drivers::LogEvent event;
  Status status = Status::ok;
  std::uint64_t timeless = 0;
  while ((status = reader_.next(event)) == Status::ok) {
    ++events_;
    if (event.timestamp_us > kFarthestUs || event.timestamp_us < -kFarthestUs) {
      if (++timeless == 1) {
        problems_.push_back(path + ": byte " + std::to_string(event.offset) + ": an event of channel " +
                            std::string(event.channel) +
                            " lies more than 146 years from the epoch; such events are left out");
      }
      continue;
    }
    channels_[std::string(event.channel)].push_back({event.timestamp_us, event.data});
    if (event.channel.starts_with("SORTIE_") && !event.channel.starts_with(drivers::kChannelCustom)) continue;
    const rt::Nanoseconds received = event.timestamp_us * rt::kNanosecondsPerMicrosecond;
    if (first_sample_ns_ == 0 || received < first_sample_ns_) first_sample_ns_ = received;
    if (received > last_sample_ns_) last_sample_ns_ = received;
  }
  if (status == Status::malformed) {
    damage_ = path + ": " + reader_.problem().describe() + "; everything before it is used";
    problems_.push_back(damage_);
  }
  const auto& headers = channel(std::string(drivers::kChannelHeader));
  if (headers.empty()) {
    throw InputError(path + ": an LCM log without a SORTIE_HEADER event among its " +
                     std::to_string(events_) +
                     " events; record one with `sortie run --record`, or import data with `sortie import`");
  }
  if (drivers::decode(headers.front().message, header_) != Status::ok ||
      header_.epoch_ns / 1000 > kFarthestUs || header_.epoch_ns / 1000 < -kFarthestUs) {
    throw InputError(path +
                     ": the SORTIE_HEADER event is damaged or of another version; record or import it again");
  }
  for (const StoredEvent& stored : channel(std::string(drivers::kChannelGap))) {
    drivers::GapRecord gap;
    if (drivers::decode(stored.message, gap) != Status::ok) continue;
    whole_until_ = std::min(whole_until_, static_cast<rt::Tick>(gap.tick));
    problems_.push_back(path + ": GAP from tick " + std::to_string(gap.tick) + ": " +
                        std::to_string(gap.lost) + " " + gap.reason + "; the part before it replays");
  }
}

const std::vector<StoredEvent>& LogFile::channel(const std::string& name) const {
  static const std::vector<StoredEvent> none;
  const auto found = channels_.find(name);
  return found == channels_.end() ? none : found->second;
}

Trajectory LogFile::truth() const {
  Trajectory truth;
  for (const StoredEvent& stored : channel(std::string(drivers::kChannelTruth))) {
    rt::TruthSample sample;
    if (drivers::decode(stored.message, sample) == Status::ok) truth.push_back(to_timed_pose(sample));
  }
  tidy(truth);
  return truth;
}

}  // namespace sortie::firmware
