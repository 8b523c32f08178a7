// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/keyframe_state.hpp"

#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "rt/digest.hpp"

namespace sortie::firmware {

namespace {

void archive_all(rt::Archive& archive, Runtime& runtime, LogFeed& feed, rt::Tick tick) {
  runtime.archive(archive, tick);
  feed.archive(archive, tick);
}

std::string fault_of(const rt::Archive& archive) {
  return std::string(archive.where()) + ": " + archive.why();
}

}  // namespace

KeyframeHead keyframe_head(const LogFile& log, const Runtime& runtime) {
  KeyframeHead head;
  head.version = version();
  head.vehicle = runtime.profile().vehicle();
  head.scene_hash = runtime.profile().hash();
  head.log_bytes = log.bytes();
  head.log_events = log.events();
  const auto header = log.channel(std::string(drivers::kChannelHeader)).front().message;
  head.log_header_digest = rt::digest_bytes(header.data(), header.size());
  head.base_tick_ns = runtime.executive().base_tick_ns();
  head.groups = runtime.group_table();
  head.tasks = runtime.task_table();
  return head;
}

void refuse_foreign(const KeyframeFile& file, const KeyframeHead& wanted, const std::string& log_path) {
  const KeyframeHead& head = file.head();
  const auto refuse = [&](const std::string& why) {
    throw InputError(file.path() + ": " + why + "; make them again with `sortie index " + log_path + "`", 2);
  };
  if (head.version != wanted.version)
    refuse("keyframes of version " + head.version + ", this is " + wanted.version);
  if (head.log_header_digest != wanted.log_header_digest) refuse("keyframes of another log");
  if (head.log_bytes != wanted.log_bytes || head.log_events != wanted.log_events) {
    refuse("the log had " + std::to_string(head.log_bytes) + " bytes when the keyframes were made and has " +
           std::to_string(wanted.log_bytes) + " now");
  }
  if (head.vehicle != wanted.vehicle || head.scene_hash != wanted.scene_hash ||
      head.base_tick_ns != wanted.base_tick_ns || head.groups != wanted.groups ||
      head.tasks != wanted.tasks) {
    refuse(
        "keyframes of another profile: a state fits only the scene and the settings that it grew under, so "
        "give `index` the same --scene and --set");
  }
}

std::vector<std::uint8_t> save_state(Runtime& runtime, LogFeed& feed, rt::Tick tick) {
  rt::Archive measure = rt::Archive::measuring();
  archive_all(measure, runtime, feed, tick);
  if (measure.status() != Status::ok) throw InputError("no keyframe can be made: " + fault_of(measure), 2);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  archive_all(write, runtime, feed, tick);
  if (write.status() != Status::ok || write.bytes() != bytes.size())
    throw InputError("no keyframe can be made: the state changed while it was written; " + fault_of(write),
                     3);
  return bytes;
}

void restore_state(std::span<const std::uint8_t> state, Runtime& runtime, LogFeed& feed, rt::Tick tick) {
  rt::Archive read = rt::Archive::reading(state);
  archive_all(read, runtime, feed, tick);
  if (read.status() != Status::ok || read.bytes() != state.size()) {
    throw InputError("the keyframe of tick " + std::to_string(tick) + " does not fit this program (" +
                     (read.status() == Status::ok ? "bytes are left over" : fault_of(read)) +
                     "); make it again with `sortie index LOG`");
  }
  for (const auto& port : runtime.parts().ports()) port->resume();
}

}  // namespace sortie::firmware
