// SPDX-License-Identifier: BSD-3-Clause
// Numbers that may change while a group runs. A change is a sample like any other: latched at a release,
// recorded with the job that took it, applied before that job's other tasks, and applied again by a replay.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/keys.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// Most parameters of one group, and the longest name in bytes.
inline constexpr std::uint32_t kMaxParametersPerGroup = 16;
inline constexpr std::uint32_t kMaxParameterName = 47;

/// One change on its way to the group that owns the parameter.
struct ParameterChange {
  Nanoseconds stamp_ns{};              ///< when it was asked for, on the run's clock
  char name[kMaxParameterName + 1]{};  ///< as in the profile; zeros fill the rest
  double value{};
  SORTIE_FIELDS(stamp_ns, name, value)
};

/// The name of a change; ends at the first zero.
inline std::string_view name_of(const ParameterChange& change) {
  std::size_t length = 0;
  while (length < sizeof(change.name) && change.name[length] != '\0') ++length;
  return {change.name, length};
}

/// Fills a change. `out_of_range` when the name is empty, too long or holds a zero; then nothing is changed.
inline Status make_change(std::string_view name, double value, Nanoseconds stamp_ns,
                          ParameterChange& change) {
  if (name.empty() || name.size() > kMaxParameterName || name.find('\0') != std::string_view::npos)
    return Status::out_of_range;
  change = {};
  change.stamp_ns = stamp_ns;
  std::memcpy(change.name, name.data(), name.size());
  change.value = value;
  return Status::ok;
}

/// What is in force after a job's changes: the output of a group's parameter task, so that it stands in the
/// digest. Places beyond the group's parameters stay 0.
struct ParameterState {
  Nanoseconds stamp_ns{};  ///< of the newest change that was applied
  std::uint32_t applied{};
  std::uint32_t refused{};  ///< changes that reached the job and were not applied
  double value[kMaxParametersPerGroup]{};
  SORTIE_FIELDS(stamp_ns, applied, refused, value)
};

/// The parameters of one group. Built at set-up; then check() and the entries are for any thread, everything
/// else only for the group's jobs. No heap; 1.3 kB. Cost of a change: one comparison of names a parameter.
class ParameterTable {
 public:
  /// Takes a value that lies within its range. May refuse it for a reason of its own; then nothing changed.
  using Setter = Status (*)(void* self, double value);

  /// One parameter, as it was added.
  struct Entry : KeyRange {
    std::string_view name;
    Setter set{};
    void* self{};
  };

  /// Set-up: adds a parameter. `name` and `self` outlive the table. `full` beyond 16; `out_of_range` for a
  /// name that is too long or there already, or a range without `initial` in it.
  Status add(const char* name, const KeyRange& range, double initial, Setter set, void* self) {
    const std::string_view text(name);
    if (text.empty() || text.size() > kMaxParameterName || find(text) < entries_.size() ||
        !(range.low <= initial && initial <= range.high))
      return Status::out_of_range;
    if (!entries_.push_back({range, text, set, self})) return Status::full;
    state_.value[entries_.size() - 1] = initial;
    return Status::ok;
  }

  /// What would become of a change, as far as name and range tell: ok, not_supported (no such parameter
  /// here), not_finite, out_of_range.
  Status check(std::string_view name, double value) const {
    const std::uint32_t index = find(name);
    if (index >= entries_.size()) return Status::not_supported;
    if (!std::isfinite(value)) return Status::not_finite;
    return value >= entries_[index].low && value <= entries_[index].high ? Status::ok : Status::out_of_range;
  }

  /// Applies a change, or counts its refusal: check()'s reasons, or the setter's own.
  Status apply(const ParameterChange& change) {
    const std::string_view name = name_of(change);
    Status status = check(name, change.value);
    if (status == Status::ok) {
      const std::uint32_t index = find(name);
      status = entries_[index].set(entries_[index].self, change.value);
      if (status == Status::ok) state_.value[index] = change.value;
    }
    if (status == Status::ok) {
      ++state_.applied;
      state_.stamp_ns = change.stamp_ns;
    } else {
      ++state_.refused;
    }
    return status;
  }

  /// Puts every parameter back to what `state` says is in force, for a run that begins in the middle. A value
  /// that is refused because another still has its old one is tried again. Returns what is refused for good.
  Status restore(const ParameterState& state) {
    Status refusal = Status::ok;
    for (std::uint32_t pass = 0; pass <= entries_.size(); ++pass) {
      refusal = Status::ok;
      for (std::uint32_t i = 0; i < entries_.size(); ++i) {
        Status status = check(entries_[i].name, state.value[i]);
        if (status == Status::ok) status = entries_[i].set(entries_[i].self, state.value[i]);
        if (status != Status::ok) refusal = status;
      }
      if (refusal == Status::ok) break;
    }
    state_ = state;
    return refusal;
  }
  /// The values in force; reading puts them in force.
  void archive(Archive& archive) {
    Members(archive, *this, "parameters").fixed(entries_).by_hand(state_);
    ParameterState state = state_;
    archive.value(state);
    if (archive.is_reading() && archive.status() == Status::ok && restore(state) != Status::ok)
      archive.fail(Status::malformed, "a parameter has a value that it cannot have");
  }

  const ParameterState& state() const { return state_; }
  std::uint32_t size() const { return entries_.size(); }
  /// In the order in which they were added; `index` < size() is not checked.
  const Entry& operator[](std::uint32_t index) const { return entries_[index]; }

 private:
  std::uint32_t find(std::string_view name) const {
    std::uint32_t index = 0;
    while (index < entries_.size() && entries_[index].name != name) ++index;
    return index;
  }

  FixedVector<Entry, kMaxParametersPerGroup> entries_;
  ParameterState state_;
};

}  // namespace sortie::rt
