// SPDX-License-Identifier: BSD-3-Clause
// The run-time parameters of a vehicle: who owns them, and where a change is handed in.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "firmware_like/runtime/input_port.hpp"
#include "rt/parameter.hpp"
#include "rt/task.hpp"

namespace sortie::firmware {

/// Takes a new value, or refuses it; then nothing has changed.
using ParameterSetter = std::function<Status(double value)>;

/// Changes that may wait for one group, and that one job applies.
inline constexpr std::uint32_t kWaitingChanges = 16;

/// The parameters of one group, the stream that brings changes, and the task that applies them.
struct ParameterGroup {
  std::uint16_t group{};
  rt::ParameterTable table;
  rt::Stream<rt::ParameterChange>* stream{};
  InputPort<rt::ParameterChange>* port{};
  const rt::Task<rt::ParameterState>* task{};
  std::vector<std::unique_ptr<ParameterSetter>> setters;
};

/// The work of a group's parameter task.
struct ApplyChanges {
  ParameterGroup* owner;
  void operator()(rt::JobContext&, rt::ParameterState& output) const {
    // A refusal is counted in the output, which everybody sees.
    for (const rt::ParameterChange& change : *owner->stream) static_cast<void>(owner->table.apply(change));
    output = owner->table.state();
  }
  void archive(rt::Archive& archive) { owner->table.archive(archive); }
};

/// Where one parameter is, for those who ask from outside.
struct ParameterInfo {
  ParameterGroup* owner{};
  std::uint32_t index{};  ///< in the owner's table and state
  /// Its name, range, unit and meaning.
  const rt::ParameterTable::Entry& key() const { return owner->table[index]; }
};

/// Every parameter of a vehicle, in order of declaration.
struct ParameterSet {
  std::vector<std::unique_ptr<ParameterGroup>> groups;
  std::vector<ParameterInfo> all;

  /// The parameter of that name, or null.
  const ParameterInfo* find(std::string_view name) const {
    for (const ParameterInfo& info : all) {
      if (info.key().name == name) return &info;
    }
    return nullptr;
  }
};

}  // namespace sortie::firmware
