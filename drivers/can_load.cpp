// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can_load.hpp"

#include <algorithm>
#include <stdexcept>

#include "drivers/can_timing.hpp"

namespace sortie::drivers {
namespace {

using rt::Nanoseconds;

constexpr Nanoseconds kUnbounded = -1;
// Waits beyond this are called endless; so is a search that does not settle.
constexpr Nanoseconds kTooLong = 10 * rt::kNanosecondsPerSecond;
constexpr int kMaxRounds = 1000;

struct Stream {
  std::uint32_t key{};  // lower wins
  Nanoseconds bus_ns{};
  Nanoseconds period_ns{};
  Nanoseconds own_jitter_ns{};
  int after{-1};
  std::size_t group{};
  // Present round:
  Nanoseconds jitter_ns{};    // own, and what it waits for
  Nanoseconds head_ns{};      // from due to the head of its queue, at most
  Nanoseconds response_ns{};  // from due to its last bit and the intermission, at most
};

// What decides who wins the bus. Throws where no bus has such a stream.
std::uint32_t key_of(const CanStream& s, std::size_t count, std::size_t index) {
  CanFrame frame;
  frame.id = s.id;
  frame.size = s.size;
  frame.flags = static_cast<std::uint8_t>(s.extended ? kCanExtended : 0);
  const auto fail = [&](const char* why) { throw std::runtime_error("CAN frame " + s.name + ": " + why); };
  if (!can_frame_valid(frame)) fail("no bus carries this identifier and size");
  if (s.period_ns <= 0 || s.period_ns > 1000 * kTooLong) fail("its period must be above 0");
  if (s.jitter_ns < 0 || s.jitter_ns > kTooLong) fail("its jitter lies in 0 to 10 s");
  if (s.after >= 0 &&
      (static_cast<std::size_t>(s.after) >= count || static_cast<std::size_t>(s.after) == index))
    fail("it follows a frame that is not there");
  return can_arbitration_key(frame);
}

// Frames due in a window, when the first was `late_ns` late and the others are not.
Nanoseconds arrivals(Nanoseconds window_ns, Nanoseconds late_ns, Nanoseconds period_ns) {
  return (window_ns + late_ns) / period_ns + 1;
}

class Bus {
 public:
  Bus(Nanoseconds bit_ns, std::vector<Stream> streams, std::size_t groups)
      : bit_ns_(bit_ns), streams_(std::move(streams)), groups_(groups) {}

  // Rounds, because the jitter of answers and the time in queues follow from response times; each round can
  // only lengthen them. What has no bound makes everything that hangs on it unbounded.
  void solve() {
    for (Stream& s : streams_) s.response_ns = s.bus_ns;
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::vector<Stream> before = streams_;
      for (Stream& s : streams_) prepare(s, before);
      for (std::size_t group = 0; group < groups_; ++group) {
        if (solve_group(group)) continue;
        for (Stream& s : streams_) {
          if (s.group == group) s.response_ns = kUnbounded;
        }
      }
      bool changed = false;
      for (std::size_t i = 0; i < streams_.size(); ++i)
        changed = changed || streams_[i].response_ns != before[i].response_ns;
      if (!changed) return;
    }
    for (Stream& s : streams_) s.response_ns = kUnbounded;
  }

  const std::vector<Stream>& streams() const { return streams_; }

 private:
  void prepare(Stream& s, const std::vector<Stream>& before) const {
    const Nanoseconds cause = s.after < 0 ? 0 : before[static_cast<std::size_t>(s.after)].response_ns;
    s.jitter_ns = cause == kUnbounded ? kUnbounded : s.own_jitter_ns + cause;
    if (s.jitter_ns >= s.period_ns) s.jitter_ns = kUnbounded;
    s.head_ns = s.jitter_ns;
    if (s.jitter_ns == kUnbounded || size_of(s.group) == 1) return;
    s.head_ns = s.response_ns == kUnbounded ? kUnbounded : std::max(s.jitter_ns, s.response_ns - s.bus_ns);
  }

  std::size_t size_of(std::size_t group) const {
    return static_cast<std::size_t>(
        std::count_if(streams_.begin(), streams_.end(), [&](const Stream& s) { return s.group == group; }));
  }

  // What other senders' more urgent frames take of a window that is open for `window_ns`; a frame that comes
  // within the first bit of an arbitration still takes part.
  Nanoseconds urgent(std::size_t group, std::uint32_t key, Nanoseconds window_ns) const {
    Nanoseconds sum = 0;
    for (const Stream& s : streams_) {
      if (s.group == group || s.key > key) continue;
      if (s.head_ns == kUnbounded) return 2 * kTooLong;
      sum += arrivals(window_ns + bit_ns_ - 1, s.head_ns, s.period_ns) * s.bus_ns;
    }
    return sum;
  }

  // What the group itself was given in the first `window_ns`, its end included.
  Nanoseconds own(std::size_t group, Nanoseconds window_ns) const {
    Nanoseconds sum = 0;
    for (const Stream& s : streams_) {
      if (s.group == group) sum += arrivals(window_ns, s.jitter_ns, s.period_ns) * s.bus_ns;
    }
    return sum;
  }

  // The shortest time that holds `fixed_ns` and all that interferes meanwhile; kUnbounded: there is none.
  Nanoseconds settle(std::size_t group, std::uint32_t key, Nanoseconds fixed_ns) const {
    Nanoseconds w = fixed_ns;
    while (w <= kTooLong) {
      const Nanoseconds next = fixed_ns + urgent(group, key, w);
      if (next == w) return w;
      w = next;
    }
    return kUnbounded;
  }

  bool solve_group(std::size_t group) {
    std::uint32_t key = 0;  // of the least urgent frame: the queue is no faster than this one at its head
    for (const Stream& s : streams_) {
      if (s.group != group) continue;
      if (s.response_ns == kUnbounded || s.jitter_ns == kUnbounded) return false;
      key = std::max(key, s.key);
    }
    Nanoseconds blocking = 0;  // a less urgent frame that has just begun
    for (const Stream& s : streams_) {
      if (s.group != group && s.key > key) blocking = std::max(blocking, s.bus_ns);
    }
    // Frames are handed over at 0 and whenever the count of some stream of the group rises, as long as the
    // bus has not become free for this group in between.
    for (Nanoseconds a = 0; a >= 0; a = next_arrival(group, a)) {
      if (a > kTooLong) return false;
      const Nanoseconds given = own(group, a);
      for (Stream& s : streams_) {
        if (s.group != group) continue;
        const Nanoseconds q = (a + s.jitter_ns) / s.period_ns;
        if (a > q * s.period_ns) continue;  // its last one came earlier: judged there
        const Nanoseconds w = settle(group, key, blocking + given - s.bus_ns);
        if (w == kUnbounded) return false;
        s.response_ns = std::max(s.response_ns, w + s.bus_ns - (q * s.period_ns - s.jitter_ns));
      }
      const Nanoseconds busy = settle(group, key, blocking + given);
      if (busy == kUnbounded) return false;
      if (next_arrival(group, a) >= busy) break;
    }
    return true;
  }

  // The next moment after `a` at which the group can be given another frame.
  Nanoseconds next_arrival(std::size_t group, Nanoseconds a) const {
    Nanoseconds next = 2 * kTooLong;
    for (const Stream& s : streams_) {
      if (s.group != group) continue;
      const Nanoseconds at = ((a + s.jitter_ns) / s.period_ns + 1) * s.period_ns - s.jitter_ns;
      next = std::min(next, at);
    }
    return next;
  }

  Nanoseconds bit_ns_;
  std::vector<Stream> streams_;
  std::size_t groups_;
};

}  // namespace

CanLoad can_load(std::uint32_t bitrate, std::span<const CanStream> streams) {
  if (bitrate == 0 || rt::kNanosecondsPerSecond % bitrate != 0)
    throw std::runtime_error("a CAN bus needs a bit rate that divides 1e9, such as 500000");
  const Nanoseconds bit_ns = rt::kNanosecondsPerSecond / bitrate;
  std::vector<Stream> rows;
  std::vector<int> queues;  // of the groups; a stream without a queue is a group of its own
  CanLoad load;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const CanStream& s = streams[i];
    Stream row;
    row.key = key_of(s, streams.size(), i);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].key == row.key)
        throw std::runtime_error("CAN frames " + streams[k].name + " and " + s.name + " have one identifier");
    }
    row.bus_ns = (can_frame_bits_worst(s.size, s.extended) + kCanIntermissionBits) * bit_ns;
    row.period_ns = s.period_ns;
    row.own_jitter_ns = s.jitter_ns;
    row.after = s.after;
    const auto known = s.queue < 0 ? queues.end() : std::find(queues.begin(), queues.end(), s.queue);
    row.group = static_cast<std::size_t>(known - queues.begin());
    if (known == queues.end()) queues.push_back(s.queue);
    rows.push_back(row);
    load.streams.push_back(
        {row.bus_ns, static_cast<double>(row.bus_ns) / static_cast<double>(s.period_ns), kUnbounded});
    load.share += load.streams.back().share;
  }
  Bus bus(bit_ns, rows, queues.size());
  bus.solve();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Nanoseconds response = bus.streams()[i].response_ns;
    if (response != kUnbounded) load.streams[i].worst_ns = response - kCanIntermissionBits * bit_ns;
  }
  return load;
}

}  // namespace sortie::drivers
