// SPDX-License-Identifier: BSD-3-Clause
// The release/acquire memory model of C++ for the explorer: a load may return any store that coherence and
// happens-before still allow, and plain data is checked for races with vector clocks. The code under test is
// the real one; only its std::atomic and its element type are replaced.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/rt/interleaving.hpp"

namespace sortie::rt::test {

/// What a faulty variant of the code under test does differently.
struct Faithful {
  static constexpr bool kRelaxedStores = false;
  static constexpr bool kRelaxedLoads = false;
  static constexpr bool kSplitExchange = false;
};
struct StoresAreRelaxed : Faithful {
  static constexpr bool kRelaxedStores = true;
};
struct LoadsAreRelaxed : Faithful {
  static constexpr bool kRelaxedLoads = true;
};
struct ExchangeIsLoadThenStore : Faithful {
  static constexpr bool kSplitExchange = true;
};

/// Twin of std::atomic under the explorer.
template <class T, class Fault>
class ModelAtomic {
 public:
  ModelAtomic(T value = T{}) { history_.push_back({value, {}, {}, kOutside}); }  // NOLINT: as std::atomic's
  ModelAtomic(const ModelAtomic&) = delete;
  ModelAtomic& operator=(const ModelAtomic&) = delete;

  T load(std::memory_order order) const {
    Explorer& explorer = Explorer::instance();
    const bool own = history_.back().writer == explorer.current();
    if (!own) explorer.yield();
    std::size_t oldest = explorer.current() == kOutside ? history_.size() - 1 : seen();
    const Clock known = explorer.clock();
    for (std::size_t i = history_.size(); i-- > oldest + 1;) {
      const int writer = history_[i].writer;
      const bool happened_before =
          writer == kOutside ||
          history_[i].stamp[static_cast<std::size_t>(writer)] <= known[static_cast<std::size_t>(writer)];
      if (happened_before) {
        oldest = i;
        break;
      }
    }
    const auto choices = static_cast<std::uint32_t>(history_.size() - oldest);
    const std::size_t pick = history_.size() - 1 - explorer.choose(choices);
    remember(pick);
    if (acquires(order) && !Fault::kRelaxedLoads) explorer.learn(history_[pick].released);
    return history_[pick].value;
  }

  void store(T value, std::memory_order order) {
    Explorer::instance().yield();
    append(value, order, {});
  }

  // Reads the last value in the order of modification, as every read-modify-write does.
  T exchange(T value, std::memory_order order) {
    return modify(order, [value](T) { return value; });
  }
  T fetch_add(T more, std::memory_order order) {
    return modify(order, [more](T old) { return static_cast<T>(old + more); });
  }

 private:
  struct Entry {
    T value;
    Clock stamp;     // the writer's clock at the store
    Clock released;  // what an acquiring reader learns
    int writer;
  };

  static bool acquires(std::memory_order order) {
    return order == std::memory_order_acquire || order == std::memory_order_acq_rel ||
           order == std::memory_order_seq_cst;
  }
  static bool releases(std::memory_order order) {
    return order == std::memory_order_release || order == std::memory_order_acq_rel ||
           order == std::memory_order_seq_cst;
  }

  template <class Function>
  T modify(std::memory_order order, Function change) {
    Explorer& explorer = Explorer::instance();
    explorer.yield();
    const Entry last = history_.back();
    if (acquires(order) && !Fault::kRelaxedLoads) explorer.learn(last.released);
    if (Fault::kSplitExchange) explorer.yield();
    append(change(last.value), order, last.released);
    return last.value;
  }

  void append(T value, std::memory_order order, Clock released) {
    Explorer& explorer = Explorer::instance();
    explorer.step();
    const Clock now = explorer.current() == kOutside ? Clock{} : explorer.clock();
    if (releases(order) && !Fault::kRelaxedStores) join(released, now);
    history_.push_back({value, now, released, explorer.current()});
    remember(history_.size() - 1);
  }

  std::size_t seen() const { return seen_[static_cast<std::size_t>(Explorer::instance().current())]; }
  void remember(std::size_t index) const {
    if (Explorer::instance().current() == kOutside) return;
    seen_[static_cast<std::size_t>(Explorer::instance().current())] = index;
  }

  std::vector<Entry> history_;
  mutable std::array<std::size_t, kThreads> seen_{};
};

template <class T>
using Modelled = ModelAtomic<T, Faithful>;
template <class T>
using RelaxedStores = ModelAtomic<T, StoresAreRelaxed>;
template <class T>
using RelaxedLoads = ModelAtomic<T, LoadsAreRelaxed>;
template <class T>
using SplitExchange = ModelAtomic<T, ExchangeIsLoadThenStore>;

/// Plain data that reports a data race: two accesses, one of them a write, neither of which happens before
/// the other.
class Tracked {
 public:
  Tracked() = default;
  Tracked(int value) : value_(value) {}  // NOLINT: stands for a plain value
  Tracked(const Tracked& other) noexcept : value_(other.read()) {}
  Tracked& operator=(const Tracked& other) noexcept {
    write(other.read());
    return *this;
  }

  int read() const noexcept {
    Explorer& explorer = Explorer::instance();
    if (!known(writer_, write_stamp_)) explorer.fail();
    if (explorer.current() != kOutside) {
      const auto thread = static_cast<std::size_t>(explorer.current());
      read_stamps_[thread] = explorer.step();
    }
    return value_;
  }

  void write(int value) noexcept {
    Explorer& explorer = Explorer::instance();
    if (!known(writer_, write_stamp_)) explorer.fail();
    for (int thread = 0; thread < kThreads; ++thread) {
      if (!known(thread, read_stamps_[static_cast<std::size_t>(thread)])) explorer.fail();
    }
    value_ = value;
    writer_ = explorer.current();
    write_stamp_ = explorer.step();
  }

 private:
  static bool known(int thread, std::uint32_t stamp) {
    const Explorer& explorer = Explorer::instance();
    if (thread == kOutside || thread == explorer.current()) return true;
    return stamp <= explorer.clock()[static_cast<std::size_t>(thread)];
  }

  int value_{0};
  int writer_{kOutside};
  std::uint32_t write_stamp_{0};
  mutable std::array<std::uint32_t, kThreads> read_stamps_{};
};

}  // namespace sortie::rt::test
