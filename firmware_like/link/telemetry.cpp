// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/link/telemetry.hpp"

#include <algorithm>
#include <chrono>

#include "drivers/wire.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_segments.hpp"
#include "drivers/wire_telemetry.hpp"
#include "rt/built_parts.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/make_thread.hpp"

namespace sortie::firmware {

namespace {

drivers::LcmPublisherConfig publisher_config(const std::string& url) {
  drivers::LcmPublisherConfig config;
  config.url = url;
  config.slot_bytes = Telemetry::kLongestMessage;
  return config;
}

}  // namespace

Telemetry::Telemetry(Runtime& runtime, const LogRecorder& recorder, const RequestDoor& desk,
                     const std::string& url, rt::Nanoseconds utc_minus_run_ns)
    : runtime_(runtime),
      recorder_(recorder),
      desk_(desk),
      utc_minus_run_ns_(utc_minus_run_ns),
      publisher_(publisher_config(url)) {
  std::size_t longest = 0;
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i) {
    longest = std::max<std::size_t>(longest, runtime.executive().task(i).output_bytes());
  }
  canonical_.resize(longest);
  for (const auto& group : runtime.parts().parameters().groups) in_force_[group.get()] = group->table.state();
}

Telemetry::~Telemetry() { stop(); }

// What the network does not take is counted by the publisher.
template <class... What>
void Telemetry::publish(std::string_view channel, const What&... what) {
  static_cast<void>(publisher_.publish_encoded(channel, [&](std::span<std::uint8_t> out, std::size_t& size) {
    return drivers::encode(what..., out, size);
  }));
}

void Telemetry::publish_fields(std::int64_t utime, const std::string& name,
                               const std::vector<drivers::NamedValue>& values) {
  publish(std::string(drivers::kChannelFields) + "_" + name, drivers::FieldsView{utime, name, values});
}

void Telemetry::publish_outputs(std::int64_t utime) {
  rt::Executive& executive = runtime_.executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    rt::TaskBase& task = executive.task(i);
    if (!task.poll_output(canonical_.data())) continue;
    std::vector<drivers::NamedValue> values;
    task.describe(
        canonical_.data(),
        {&values, [](void* self, const char* name, int index, double value, std::uint64_t, std::uint32_t) {
           std::string full = name;
           if (index >= 0) full += "[" + std::to_string(index) + "]";
           static_cast<std::vector<drivers::NamedValue>*>(self)->push_back({full, value});
         }});
    publish_fields(utime, task.name(), values);
    note_parameters(task);
    note_state(task, values);
    if (&task == runtime_.vehicle().pose_task()) {
      rt::PoseEstimate pose;
      rt::decode_canonical(canonical_.data(), pose);
      publish(drivers::kChannelPose,
              drivers::to_pose_message(pose, (pose.stamp_ns + utc_minus_run_ns_) / 1000));
    }
  }
}

void Telemetry::publish_motors(std::int64_t utime) {
  const std::optional<MotorsNews> news = runtime_.vehicle().motors_news();
  if (!news) return;
  publish_fields(utime, "motors",
                 {{"emergency", news->emergency ? 1.0 : 0.0},
                  {"running", news->running ? 1.0 : 0.0},
                  {"stop_reason", static_cast<double>(news->stop_reason)}});
}

void Telemetry::note_parameters(const rt::TaskBase& task) {
  for (auto& [group, state] : in_force_) {
    if (group->task != &task) continue;
    const std::uint32_t before = state.applied + state.refused;
    rt::decode_canonical(canonical_.data(), state);
    parameters_moved_ = parameters_moved_ || state.applied + state.refused != before;
  }
}

void Telemetry::publish_parameters(std::int64_t utime, bool anyway) {
  const auto& set = runtime_.parts().parameters();
  const std::int64_t asked = desk_.parameters().newest();
  if (set.all.empty() || !(anyway || parameters_moved_ || asked != parameters_asked_)) return;
  parameters_asked_ = asked;
  parameters_moved_ = false;
  drivers::ParametersMessage message = desk_.describe();
  message.utime = utime;
  for (const ParameterInfo& info : set.all) {
    const rt::ParameterTable::Entry& key = info.key();
    message.parameters.push_back(
        {std::string(key.name), key.unit.name, in_force_[info.owner].value[info.index], key.low, key.high});
  }
  publish(drivers::kChannelParameters, message);
}

// Without the state, which must be read after them: of a task that puts nothing out there is none to tell.
void Telemetry::read_answers() {
  answers_.clear();
  desk_.for_each_answer([this](drivers::AnswersMessage message) { answers_.push_back(std::move(message)); });
}

// What those who command want to hear of the task that obeys: all of it would be too long for one datagram.
void Telemetry::note_state(const rt::TaskBase& task, const std::vector<drivers::NamedValue>& values) {
  static constexpr std::string_view kTold[] = {"source",        "stop",          "speed_m_s", "turn_rad_s",
                                               "step",          "remote",        "reached",   "setpoint_m[0]",
                                               "setpoint_m[1]", "setpoint_m[2]", "error_m"};
  for (drivers::AnswersMessage& message : answers_) {
    if (message.task != task.name()) continue;
    for (const drivers::NamedValue& value : values) {
      if (std::find(std::begin(kTold), std::end(kTold), value.name) != std::end(kTold))
        message.state.push_back(value);
    }
  }
}

void Telemetry::publish_answers(std::int64_t utime) {
  for (drivers::AnswersMessage& message : answers_) {
    message.utime = utime;
    publish(std::string(drivers::kChannelAnswers) + "_" + message.task, message, desk_.key());
  }
}

void Telemetry::publish_statistics(std::int64_t utime) {
  publish(drivers::kChannelStats, drivers::ExecStats{utime, recorder_.timings()});
  drivers::PoolStats pools{utime, {}};
  for (const auto& port : runtime_.parts().ports()) {
    const rt::StreamBase& stream = port->stream();
    pools.rows.push_back({port->channel(), stream.capacity(), stream.waiting(), stream.high_water(),
                          static_cast<std::int64_t>(stream.refused())});
  }
  publish(drivers::kChannelPools, pools);
}

void Telemetry::tell(const drivers::EventRecord& event) {
  constexpr std::size_t kMostWaiting = 1000;  // nobody empties it when telemetry is off
  const std::lock_guard lock(events_mutex_);
  if (events_.size() < kMostWaiting) events_.push_back(event);
}

void Telemetry::publish_events() {
  std::vector<drivers::EventRecord> events;
  {
    const std::lock_guard lock(events_mutex_);
    events.swap(events_);
  }
  for (const drivers::EventRecord& event : events) publish(drivers::kChannelEvent, event);
}

template <class Report>
void Telemetry::publish_reports(std::string_view channel, std::int64_t& seq) {
  ReportQueue<Report>* const queue = runtime_.parts().find<ReportQueue<Report>>();
  if (queue == nullptr) return;
  for (; Report* const report = queue->front(); queue->pop()) {
    report->stamp_ns += utc_minus_run_ns_;
    static_cast<void>(
        publisher_.publish_encoded(channel, [&](std::span<std::uint8_t> out, std::size_t& size) {
          return drivers::encode(*report, seq++, out, size);  // numbers only what is sent
        }));
  }
}

void Telemetry::start() {
  if (!publisher_.active()) return;
  thread_ = rt::posix::make_thread("telemetry", [this] {
    for (std::uint64_t round = 0; !stop_.load(std::memory_order_relaxed); ++round) {
      const std::int64_t utime =
          (runtime_.executive().now() + utc_minus_run_ns_) / rt::kNanosecondsPerMicrosecond;
      // Answers first, then the state: "admitted" and "halted" in one message were true in that order.
      read_answers();
      publish_outputs(utime);
      publish_motors(utime);
      publish_answers(utime);
      publish_events();
      publish_reports<rt::SegmentList>(drivers::kChannelSegments, segments_seq_);
      if constexpr (rt::kBuilt<"locate">)
        publish_reports<rt::LocatedPose>(drivers::kChannelLocated, located_seq_);
      if constexpr (rt::kBuilt<"recognise"> || rt::kBuilt<"recognise_images">)
        publish_reports<rt::RecognisedPlace>(drivers::kChannelRecognised, recognised_seq_);
      if (round % 10 == 9) publish_statistics(utime);
      publish_parameters(utime, round % 10 == 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    cpu_ns_.store(rt::posix::thread_cpu_now(), std::memory_order_relaxed);
  });
}

void Telemetry::stop() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

}  // namespace sortie::firmware
