// SPDX-License-Identifier: BSD-3-Clause
// The degrade ladder: who gives way, and how far, when a core has more to do than it can. Pure decisions; who
// measures the load and when is a runner's business. A level is recorded with every job, for its replay.
#pragma once

#include <array>
#include <cstdint>

namespace sortie::rt {

/// How much a task matters. Under overload C gives way before B; A never does.
enum class Criticality : std::uint8_t { a = 0, b = 1, c = 2 };

/// What a task gets at a level of the ladder.
enum class Service : std::uint8_t {
  full,     ///< every job, all its work units
  reduced,  ///< an anytime task: half of its units; any other task: every second job
  off       ///< none; its last output stands
};

/// Levels are 0 (everything runs) to kTopLevel (only criticality A runs).
inline constexpr std::uint8_t kTopLevel = 4;
inline constexpr std::uint32_t kLevels = kTopLevel + 1u;

/// Level 1: C reduced, 2: C off, 3: B reduced, 4: B off.
constexpr Service service_at(Criticality criticality, std::uint8_t level) {
  if (criticality == Criticality::a) return Service::full;
  const int reduced_from = criticality == Criticality::c ? 1 : 3;
  if (level < reduced_from) return Service::full;
  return level == reduced_from ? Service::reduced : Service::off;
}

/// Most windows that a load is averaged over.
inline constexpr std::uint8_t kMostSpan = 16;

/// When the ladder acts. Loads are shares of one core.
struct LadderConfig {
  /// Above this load, on average over `span` windows, a level is taken. Beyond about 0.9 the kernel itself
  /// may take a real-time core for 50 ms.
  double most_load{0.85};
  double return_load{0.75};      ///< a lower level is tried only if it is expected to stay below this
  std::uint8_t calm_windows{2};  ///< windows below return_load before a lower level is tried
  std::uint8_t most_backoff{6};  ///< most windows to wait after tries that failed; bounds the recovery time
  /// Windows that the load is averaged over before the ladder climbs: at least the longest period of the
  /// core's groups, or one job of a slow group would look like overload. At most kMostSpan.
  std::uint8_t span{1};
  std::uint8_t trial_windows{3};  ///< a climb within so many windows of a return means that the try failed
};

/// The ladder of one core. One update a window of some milliseconds; O(kLevels), no heap.
class Ladder {
 public:
  /// `declared`: load of the core by declared budgets at each level, falling. Only ratios of it are used.
  Ladder(const LadderConfig& config, const std::array<double, kLevels>& declared)
      : config_(config), declared_(declared), wait_(config.calm_windows) {}

  /// Takes what the last window has shown: the measured load (NaN counts as full), and whether a
  /// criticality-A job was missed. Gives the level that jobs take from now on.
  std::uint8_t update(double load, bool missed_a) {
    const double average = average_with(load);
    const bool too_much = !(average <= config_.most_load);
    if (since_return_ < 255) ++since_return_;
    if (too_much || missed_a) {
      if (since_return_ <= config_.trial_windows + config_.span && has_returned_) back_off();
      climb(too_much ? average : config_.most_load);
      calm_ = 0;
      return level_;
    }
    if (level_ == 0) {
      // Some calm at the ground floor: the next overload is a new one.
      if (since_return_ > 4 * (config_.trial_windows + config_.span)) wait_ = config_.calm_windows;
      return level_;
    }
    calm_ =
        load < config_.return_load && calm_ < 255 ? static_cast<std::uint8_t>(calm_ + 1) : std::uint8_t{0};
    descend(load);
    return level_;
  }

  std::uint8_t level() const { return level_; }

 private:
  // Mean load of the last `span` windows at this level; below the limit until there are so many.
  double average_with(double load) {
    const std::uint8_t span = config_.span == 0          ? std::uint8_t{1}
                              : config_.span > kMostSpan ? kMostSpan
                                                         : config_.span;
    loads_[newest_] = load == load ? load : 1.0;
    newest_ = static_cast<std::uint8_t>((newest_ + 1) % span);
    if (seen_ < span) ++seen_;
    if (seen_ < span) return 0;
    double sum = 0;
    for (std::uint8_t i = 0; i < span; ++i) sum += loads_[i];
    return sum / span;
  }
  // Load at `level`, foreseen from the present level's: all tasks take the same share of their budgets.
  double foreseen(double load, std::uint8_t level) const {
    const double now = declared_[level_];
    return now > 0 ? load * declared_[level] / now : declared_[level];
  }
  void climb(double load) {
    if (level_ == kTopLevel) return;
    std::uint8_t next = static_cast<std::uint8_t>(level_ + 1);
    // A NaN load climbs one step.
    while (next < kTopLevel && foreseen(load, next) > config_.return_load) ++next;
    level_ = next;
    seen_ = 0;
  }
  void descend(double load) {
    if (calm_ < wait_) return;
    std::uint8_t next = level_;
    while (next > 0 && foreseen(load, static_cast<std::uint8_t>(next - 1)) < config_.return_load) --next;
    if (next == level_) {
      // The load of those that run may foretell too much for those that do not: after a longer calm one step
      // is tried all the same, so that nothing stays off for ever.
      if (calm_ < config_.most_backoff) return;
      --next;
    }
    level_ = next;
    seen_ = 0;
    calm_ = 0;
    since_return_ = 0;
    has_returned_ = true;
  }
  void back_off() {
    const int doubled = 2 * wait_;
    wait_ = static_cast<std::uint8_t>(doubled > config_.most_backoff ? config_.most_backoff : doubled);
  }

  LadderConfig config_;
  std::array<double, kLevels> declared_;
  std::array<double, kMostSpan> loads_{};
  std::uint8_t newest_{};
  std::uint8_t seen_{};
  std::uint8_t level_{};
  std::uint8_t calm_{};
  std::uint8_t wait_;
  std::uint8_t since_return_{255};
  bool has_returned_{};
};

}  // namespace sortie::rt
