// SPDX-License-Identifier: BSD-3-Clause
// The queues that are compared, behind the same four calls.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>

#include "rt/spsc_ring.hpp"
#ifdef SORTIE_PEER_BOOST
#include <boost/lockfree/spsc_queue.hpp>
#endif

namespace sortie::bench {

/// One cache line, as most samples are.
struct Message {
  std::uint64_t words[8]{};
};

inline constexpr std::uint32_t kQueueSlots = 1024;
inline constexpr std::uint32_t kQueueBatch = 16;

struct SortieQueue {
  static constexpr const char* kName = "sortie";
  bool push(const Message& message) { return ring.try_push(message); }
  bool pop(Message& message) { return ring.try_pop(message); }
  std::uint32_t push_n(const Message* messages, std::uint32_t n) { return ring.push_n(messages, n); }
  std::uint32_t pop_n(Message* messages, std::uint32_t n) { return ring.pop_n(messages, n); }
  rt::SpscRing<Message, kQueueSlots> ring;
};

#ifdef SORTIE_PEER_BOOST
struct BoostQueue {
  static constexpr const char* kName = "boost::lockfree::spsc_queue";
  bool push(const Message& message) { return ring.push(message); }
  bool pop(Message& message) { return ring.pop(message); }
  std::uint32_t push_n(const Message* messages, std::uint32_t n) {
    return static_cast<std::uint32_t>(ring.push(messages, n));
  }
  std::uint32_t pop_n(Message* messages, std::uint32_t n) {
    return static_cast<std::uint32_t>(ring.pop(messages, n));
  }
  boost::lockfree::spsc_queue<Message, boost::lockfree::capacity<kQueueSlots>> ring;
};
#endif

struct LockedQueue {
  static constexpr const char* kName = "std::mutex + std::deque";
  bool push(const Message& message) {
    const std::lock_guard lock(mutex);
    if (queue.size() == kQueueSlots) return false;
    queue.push_back(message);
    return true;
  }
  bool pop(Message& message) {
    const std::lock_guard lock(mutex);
    if (queue.empty()) return false;
    message = queue.front();
    queue.pop_front();
    return true;
  }
  std::uint32_t push_n(const Message* messages, std::uint32_t n) {
    const std::lock_guard lock(mutex);
    std::uint32_t i = 0;
    for (; i < n && queue.size() < kQueueSlots; ++i) queue.push_back(messages[i]);
    return i;
  }
  std::uint32_t pop_n(Message* messages, std::uint32_t n) {
    const std::lock_guard lock(mutex);
    std::uint32_t i = 0;
    for (; i < n && !queue.empty(); ++i) {
      messages[i] = queue.front();
      queue.pop_front();
    }
    return i;
  }
  std::mutex mutex;
  std::deque<Message> queue;
};

/// Calls f.operator()<Queue>() for each queue of this build, ours first.
template <class F>
void for_each_queue(F&& f) {
  f.template operator()<SortieQueue>();
#ifdef SORTIE_PEER_BOOST
  f.template operator()<BoostQueue>();
#endif
  f.template operator()<LockedQueue>();
}

#ifdef SORTIE_PEER_BOOST
inline constexpr int kQueues = 3;
#else
inline constexpr int kQueues = 2;
#endif

}  // namespace sortie::bench
