// SPDX-License-Identifier: BSD-3-Clause
// What a module of the campaign gathers while a sequence runs: counts, checks, the digest, calls of the heap.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "rt/digest.hpp"
#include "rt/fields.hpp"
#include "rt/posix/heap_trap.hpp"
#include "rt/status.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

/// True when every floating-point number within is finite.
template <class T>
bool all_finite(const T& value) {
  if constexpr (std::is_array_v<T>) {
    for (const auto& element : value)
      if (!all_finite(element)) return false;
    return true;
  } else if constexpr (std::is_floating_point_v<T>) {
    return std::isfinite(value);
  } else if constexpr (rt::Described<T>) {
    bool finite = true;
    T::fields(value, [&finite](const char*, const auto& field) { finite = finite && all_finite(field); });
    return finite;
  } else {
    return true;
  }
}

/// One run of one sequence. No heap but for the text of a fault.
class CampaignTrial {
 public:
  /// An input was given to the module, and this is what it said.
  void given(Status status) { count(status == Status::ok); }
  /// The same, with what it said.
  Status answered(Status status) {
    count(status == Status::ok);
    return status;
  }
  void count(bool accepted) {
    ++outcome_.given;
    ++(accepted ? outcome_.accepted : outcome_.refused);
    fold(accepted ? 1 : 0);
  }
  /// `inputs` at once, of which the module says that it took so many and refused so many.
  void count_many(std::uint64_t inputs, std::uint64_t accepted, std::uint64_t refused) {
    outcome_.given += inputs;
    outcome_.accepted += accepted;
    outcome_.refused += refused;
    need(accepted + refused == inputs, "accepted and refused inputs are not all inputs");
  }
  /// A check. The first that fails is the sequence's fault; `what` is said without figures.
  void need(bool holds, const char* what) {
    ++outcome_.checks;
    if (!holds && outcome_.fault.empty()) outcome_.fault = what;
  }
  /// An output: finite, and part of the digest.
  template <rt::Described T>
  void see(const T& output, const char* what) {
    need(all_finite(output), what);
    outcome_.digest = rt::digest_of(output, outcome_.digest);
  }
  void see(double output, const char* what) {
    need(std::isfinite(output), what);
    fold(std::bit_cast<std::uint64_t>(std::isnan(output) ? 0.0 : output));
  }
  void fold(std::uint64_t word) { outcome_.digest = rt::digest_bytes(&word, sizeof word, outcome_.digest); }
  /// Calls the real-time part: what takes memory from the heap is a fault.
  template <class F>
  auto real_time(F&& part) {
    const rt::posix::HeapTrapScope scope;
    const auto result = part();
    heap_calls_ += scope.calls();
    return result;
  }
  bool failed() const { return !outcome_.fault.empty(); }
  CampaignOutcome end() {
    need(heap_calls_ == 0, "the real-time part called the heap");
    need(outcome_.accepted + outcome_.refused == outcome_.given,
         "accepted and refused inputs are not all inputs");
    return outcome_;
  }

 private:
  CampaignOutcome outcome_;
  std::uint64_t heap_calls_{};
};

/// The stamp of a sequence: moved by steps, at the ends of 64 bits it wraps, as a broken device's does.
struct CampaignClock {
  std::int64_t now_ns{};
  std::int64_t step(const CampaignOp& op) {
    now_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(now_ns) +
                                       static_cast<std::uint64_t>(op.step_ns));
    return now_ns;
  }
};

/// A value of an operation as a whole number in [0, n): defined for every value.
inline std::uint32_t whole_of(double value, std::uint32_t n) {
  const double size = std::fabs(value);
  if (!(size < 1e9)) return n - 1;
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(size * 1024.0)) % n;
}

}  // namespace sortie::bench
