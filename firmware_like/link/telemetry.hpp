// SPDX-License-Identifier: BSD-3-Clause
// What a run tells the outside over LCM, unasked: every task's output, run times, pools, and the pose.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/lcm_publisher.hpp"
#include "firmware_like/link/request_door.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// Publishes from a thread of its own: outputs as fields_t on SORTIE_FIELDS_<task> ten times a second,
/// the map's segments and the robot's place after each scan, statistics and the run-time parameters once a
/// second (parameters also as soon as one changes), answers to requests ten times a second where a task obeys
/// any, the pose as bot_core.pose_t on POSE_BODY. The real-time workers never wait for it: it reads their
/// mailboxes.
///
/// One offset dates everything that a run tells, on every channel, in its log and in its events: UTC at the
/// run's time 0, read once and added to the run's clock. Nothing here asks for the date again, so setting the
/// system's clock moves no channel against another; the dates are then those of the clock as it was.
class Telemetry {
 public:
  /// `url`: LCM URL, or "none". `utc_minus_run_ns`: added to all times of the executive's clock.
  Telemetry(Runtime& runtime, const LogRecorder& recorder, const RequestDoor& desk, const std::string& url,
            rt::Nanoseconds utc_minus_run_ns);
  ~Telemetry();

  /// Publishes an event with the next round. Any thread but the real-time ones.
  void tell(const drivers::EventRecord& event);
  /// Starts the thread; stop() ends it after a last message. Throws ThreadRefused.
  void start();
  void stop();
  /// Empty, or why nothing is published although it was asked for.
  const std::string& problem() const { return publisher_.problem(); }
  drivers::LcmPublisherCounters counters() const { return publisher_.counters(); }
  /// Processor time of its threads; whole after stop().
  rt::Nanoseconds cpu_ns() const { return cpu_ns_.load() + publisher_.cpu_ns(); }
  /// Memory while it is on.
  static std::size_t bytes() {
    drivers::LcmPublisherConfig config;
    config.slot_bytes = kLongestMessage;
    return sizeof(Telemetry) + drivers::LcmPublisher::bytes_for(config);
  }
  static constexpr std::size_t kLongestMessage = std::size_t{16} << 10;

 private:
  template <class... What>
  void publish(std::string_view channel, const What&... what);
  void publish_fields(std::int64_t utime, const std::string& name,
                      const std::vector<drivers::NamedValue>& values);
  void publish_outputs(std::int64_t utime);
  void publish_motors(std::int64_t utime);
  void publish_statistics(std::int64_t utime);
  void publish_events();
  // What parts have put into their queues.
  template <class Report>
  void publish_reports(std::string_view channel, std::int64_t& seq);
  void note_parameters(const rt::TaskBase& task);
  void publish_parameters(std::int64_t utime, bool anyway);
  void read_answers();
  void note_state(const rt::TaskBase& task, const std::vector<drivers::NamedValue>& values);
  void publish_answers(std::int64_t utime);

  Runtime& runtime_;
  const LogRecorder& recorder_;
  const RequestDoor& desk_;
  rt::Nanoseconds utc_minus_run_ns_;
  drivers::LcmPublisher publisher_;
  std::vector<std::uint8_t> canonical_;
  std::mutex events_mutex_;
  std::vector<drivers::EventRecord> events_;
  std::map<const ParameterGroup*, rt::ParameterState> in_force_;  // as the tasks put it out
  std::vector<drivers::AnswersMessage> answers_;                  // of this round
  bool parameters_moved_{};
  std::int64_t parameters_asked_{};  // counter of the newest change that was asked for
  std::int64_t segments_seq_{};
  std::int64_t located_seq_{};
  std::int64_t recognised_seq_{};
  std::atomic<rt::Nanoseconds> cpu_ns_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sortie::firmware
