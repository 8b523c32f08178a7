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
#include "tests/rt/model_orders.hpp"

namespace sortie::rt::test {

/// Twin of std::atomic under the explorer. `kSplits`: planted fault, a read-modify-write is a load and then a
/// store. Memory orders are taken away one by one: see model_orders.hpp. A weak exchange never fails without
/// a cause here: its loop would only look again.
template <class T, bool kSplits>
class ModelAtomic {
 public:
  using value_type = T;

  ModelAtomic(T value = T{}) {
    history_.push_back({value, {}, {}, kOutside, false});
  }  // NOLINT: as std::atomic's
  ModelAtomic(const ModelAtomic&) = delete;
  ModelAtomic& operator=(const ModelAtomic&) = delete;

  T load(std::memory_order order, Caller where = Caller::here()) const {
    Explorer& explorer = Explorer::instance();
    // A word that this thread stores is stored by no other (see append): nothing can come in between.
    if (!history_.back().stored || history_.back().writer != explorer.current()) explorer.yield();
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
    if (acquires(order, {where, "load acquire"})) explorer.learn(history_[pick].released);
    return history_[pick].value;
  }

  void store(T value, std::memory_order order, Caller where = Caller::here()) {
    Explorer::instance().yield();
    append(value, releases(order, {where, "store release"}), {}, true);
  }

  // Reads the last value in the order of modification, as every read-modify-write does.
  T exchange(T value, std::memory_order order, Caller where = Caller::here()) {
    return modify(acquires(order, {where, "exchange acquire"}), releases(order, {where, "exchange release"}),
                  [value](T) { return value; });
  }
  T fetch_add(T more, std::memory_order order, Caller where = Caller::here()) {
    return modify(acquires(order, {where, "fetch_add acquire"}),
                  releases(order, {where, "fetch_add release"}),
                  [more](T old) { return static_cast<T>(old + more); });
  }
  bool compare_exchange_strong(T& expected, T wanted, std::memory_order success, std::memory_order failure,
                               Caller where = Caller::here()) {
    Explorer& explorer = Explorer::instance();
    const bool acquired = acquires(success, {where, "compare_exchange acquire"});
    const bool released = releases(success, {where, "compare_exchange release"});
    const bool acquired_failing = acquires(failure, {where, "compare_exchange failure acquire"});
    explorer.yield();
    const Entry last = history_.back();
    if (last.value != expected) {
      // A failure is a load: it may also see an older value, as long as that is not the expected one.
      if (acquired_failing) explorer.learn(last.released);
      remember(history_.size() - 1);
      expected = last.value;
      return false;
    }
    if (acquired) explorer.learn(last.released);
    if (kSplits) explorer.yield();
    append(wanted, released, last.released, false);
    return true;
  }
  bool compare_exchange_weak(T& expected, T wanted, std::memory_order success, std::memory_order failure,
                             Caller where = Caller::here()) {
    return compare_exchange_strong(expected, wanted, success, failure, where);
  }

 private:
  struct Entry {
    T value;
    Clock stamp;     // the writer's clock at the store
    Clock released;  // what an acquiring reader learns
    int writer;
    bool stored;  // plainly, not by a read-modify-write
  };

  static bool acquires(std::memory_order order, const OrderSite& site) {
    return (order == std::memory_order_acquire || order == std::memory_order_acq_rel ||
            order == std::memory_order_seq_cst) &&
           Orders::instance().holds(site);
  }
  static bool releases(std::memory_order order, const OrderSite& site) {
    return (order == std::memory_order_release || order == std::memory_order_acq_rel ||
            order == std::memory_order_seq_cst) &&
           Orders::instance().holds(site);
  }

  template <class Function>
  T modify(bool acquired, bool released, Function change) {
    Explorer& explorer = Explorer::instance();
    explorer.yield();
    const Entry last = history_.back();
    if (acquired) explorer.learn(last.released);
    if (kSplits) explorer.yield();
    append(change(last.value), released, last.released, false);
    return last.value;
  }

  void append(T value, bool release, Clock released, bool stored) {
    Explorer& explorer = Explorer::instance();
    // Two threads that store one word plainly are a fault in all types here, and load() relies on it.
    const Entry& last = history_.back();
    if (last.stored && last.writer != kOutside && explorer.current() != kOutside &&
        last.writer != explorer.current())
      explorer.fail();
    explorer.step();
    const Clock now = explorer.current() == kOutside ? Clock{} : explorer.clock();
    if (release) join(released, now);
    history_.push_back({value, now, released, explorer.current(), stored});
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
using Modelled = ModelAtomic<T, false>;
template <class T>
using SplitExchange = ModelAtomic<T, true>;

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
