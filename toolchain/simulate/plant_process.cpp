// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/simulate/plant_process.hpp"

#include <algorithm>
#include <memory>

#include "drivers/lcm_log.hpp"
#include "drivers/scan_datagram.hpp"
#include "firmware_like/live/truth_writer.hpp"
#include "firmware_like/log/log_clock.hpp"
#include "firmware_like/log/log_recorder.hpp"
#include "rt/posix/clock.hpp"
#include "rt/posix/file_place.hpp"
#include "toolchain/simulate/plant_links.hpp"

namespace sortie::toolchain {

namespace {

constexpr std::uint32_t kMostScanPoints = 128 * 4096;

// The truth's log: a header without jobs, then events. A kill takes what was written in the last second. It
// takes its place with the first truth (rt/posix/file_place.hpp): a plant that is refused leaves the log of
// the one before.
class PlantLog final : public firmware::SampleSink {
 public:
  PlantLog(const std::string& path, const firmware::Profile& profile, const std::string& source,
           rt::Nanoseconds utc_minus_log_ns)
      : place_(path), writer_(place_.second_descriptor(), path) {
    drivers::LogHeader header;
    header.version = firmware::version();
    header.compiler = firmware::compiler_description();
    header.vehicle = profile.vehicle();
    header.scene = profile.name();
    header.scene_toml = profile.canonical();
    header.scene_hash = static_cast<std::int64_t>(profile.hash());
    header.base_tick_ns = rt::kNanosecondsPerMillisecond;
    header.utc_minus_monotonic_ns = utc_minus_log_ns;
    header.source = source;
    std::vector<std::uint8_t> message(drivers::encoded_bytes(header));
    std::size_t size = 0;
    if (drivers::encode(header, message, size) != Status::ok)
      throw std::runtime_error(
          path + ": the log's header cannot be encoded; a text in the profile holds a zero byte");
    sample(std::string(drivers::kChannelHeader), 0, {message.data(), size});
  }
  void sample(const std::string& channel, rt::Nanoseconds stamp_ns,
              std::span<const std::uint8_t> message) override {
    // A disk that is full says so in error(), and the log keeps what it has.
    static_cast<void>(writer_.append(channel, stamp_ns / rt::kNanosecondsPerMicrosecond, message));
    if (stamp_ns < next_flush_ns_) return;
    next_flush_ns_ = stamp_ns + rt::kNanosecondsPerSecond;
    static_cast<void>(writer_.flush());
  }
  /// Something worth keeping is in it.
  void take_place() {
    if (place_.taken() || !refused_.empty()) return;
    if (writer_.flush() == Status::ok) refused_ = place_.take(rt::posix::FormerFile::kept);
  }
  std::string close() {
    static_cast<void>(writer_.close());
    return refused_.empty() ? writer_.error() : refused_;
  }

 private:
  rt::posix::FilePlace place_;
  drivers::LcmLogWriter writer_;
  rt::Nanoseconds next_flush_ns_{};
  std::string refused_;
};

// The runtime as the plant sees it: there, or not.
class PeerWatch {
 public:
  explicit PeerWatch(const PlantOptions& options) : options_(options) {}
  void look(const drivers::DatagramLink& link, rt::Nanoseconds now_ns) {
    if (link.has_peer() == there_) return;
    there_ = link.has_peer();
    if (!options_.tell) return;
    const std::string when = std::to_string(now_ns / rt::kNanosecondsPerMillisecond) + " ms";
    options_.tell(there_ ? "a runtime is heard at " + when
                         : "the runtime has gone at " + when + "; its drives stop by their own rule");
  }

 private:
  const PlantOptions& options_;
  bool there_{};
};

// Steps of a millisecond of the machine's clock.
class StepPace {
 public:
  explicit StepPace(rt::Nanoseconds zero_ns)
      : zero_ns_(zero_ns), next_ns_(zero_ns), looked_ns_(rt::posix::monotonic_now()) {}
  /// Sleeps up to the next one; what is late is made up for from now on. Gives the time since zero.
  rt::Nanoseconds wait() {
    rt::posix::sleep_until(next_ns_);
    const rt::Nanoseconds woke_ns = rt::posix::monotonic_now();
    if (woke_ns - next_ns_ > 10 * rt::kNanosecondsPerMillisecond) ++late_;
    longest_ns_ = std::max(longest_ns_, woke_ns - looked_ns_);
    looked_ns_ = woke_ns;
    next_ns_ = std::max(next_ns_ + rt::kNanosecondsPerMillisecond, woke_ns);
    return woke_ns - zero_ns_;
  }
  void tell(PlantOutcome& outcome) const {
    outcome.counters["late_wakes"] = late_;
    outcome.counters["longest_step_us"] =
        static_cast<std::uint64_t>(longest_ns_ / rt::kNanosecondsPerMicrosecond);
    if (late_ != 0)
      outcome.warnings.push_back("woke " + std::to_string(late_) +
                                 " times more than 10 ms late; the sensors' samples came late as well");
  }

 private:
  rt::Nanoseconds zero_ns_;
  rt::Nanoseconds next_ns_;
  rt::Nanoseconds looked_ns_;
  rt::Nanoseconds longest_ns_{};  // between two looks at the bus: a drive hears and acts that much late
  std::uint64_t late_{};
};

}  // namespace

PlantOutcome run_plant(const firmware::SimulatorFactory& simulator, const PlantOptions& options) {
  firmware::Profile profile = firmware::load_scene(options.scene, options.overrides);
  drivers::ScanSender scans(kMostScanPoints);
  const std::unique_ptr<firmware::SimulatedRobot> robot = simulator ? simulator(profile, &scans) : nullptr;
  if (!robot || robot->vehicle_can() == nullptr)
    throw firmware::ProfileError(options.scene +
                                 ": `plant` needs a scene with a simulated robot ([hil]) that has a bus");
  profile.refuse_unknown_keys("hil");
  // The clock of the devices is the machine's, as whole milliseconds of it are steps.
  const rt::Nanoseconds now_ns = rt::posix::monotonic_now();
  const rt::Nanoseconds zero_ns = now_ns - now_ns % rt::kNanosecondsPerMillisecond;
  PlantLinks links(options.port, options.can_interface, zero_ns, *robot, scans);
  robot->set_device_clock(zero_ns);

  PlantOutcome outcome;
  outcome.scene = profile.name();
  outcome.robot = robot->describe();
  std::unique_ptr<PlantLog> log;
  if (!options.record.empty()) {
    const rt::Nanoseconds utc = rt::posix::utc_minus_monotonic() + zero_ns;
    log = std::make_unique<PlantLog>(options.record, profile, outcome.robot, utc);
    firmware::write_log_clock(*log, zero_ns, utc);
  }
  firmware::TruthWriter truth;
  PeerWatch peer(options);
  StepPace pace(zero_ns);
  const auto length_ns = static_cast<rt::Nanoseconds>(options.seconds * 1e9);
  rt::Nanoseconds since_ns = 0;
  while ((options.interrupted == nullptr || !options.interrupted->load()) &&
         (length_ns == 0 || since_ns < length_ns)) {
    since_ns = pace.wait();
    links.bring();
    robot->step(since_ns);
    links.take();
    truth.note(*robot, since_ns, log.get());
    if (log) log->take_place();
    peer.look(links.judged(), since_ns);
  }
  outcome.duration_s = static_cast<double>(since_ns) * 1e-9;
  robot->add_counters(outcome.counters);
  links.add_counters(outcome.counters);
  outcome.counters["truth_contacts_dropped"] = truth.contacts_dropped;
  if (links.judged().counters().peers == 0) outcome.warnings.push_back("no runtime was heard");
  pace.tell(outcome);
  if (log)
    if (const std::string error = log->close(); !error.empty()) outcome.warnings.push_back(error);
  return outcome;
}

}  // namespace sortie::toolchain
