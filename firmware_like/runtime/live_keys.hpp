// SPDX-License-Identifier: BSD-3-Clause
// Run-time parameters from a config's list of keys.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>

#include "firmware_like/runtime/vehicle_builder.hpp"
#include "rt/keys.hpp"

namespace sortie::firmware {

/// VehicleBuilder::parameter() for every key of Config that has a setter (rt/keys.hpp), in the list's order;
/// `table` was read before. `owner` is what the setters are called with; it outlives the jobs. `config` is of
/// use where a setter depends on another key. Throws ProfileError.
template <rt::Keyed Config, class Owner>
void live_keys(VehicleBuilder& builder, rt::GroupId group, const std::string& table, Owner& owner,
               const Config& config = {}) {
  Config::keys(
      config, [&]<class T, class Set = std::nullptr_t>(const char* name, const T&, const rt::KeySpec& spec,
                                                       Set set = {}) {
        if constexpr (!std::is_null_pointer_v<Set>) {
          builder.parameter(group, key_path(table, name), [&owner, spec, set](double value) {
            return set(owner, rt::from_written<T>(value, spec));
          });
        }
      });
}

/// The same for every key that is marked rt::kLive: it is written into `config`, which outlives the jobs.
template <rt::Keyed Config>
void live_keys(VehicleBuilder& builder, rt::GroupId group, const std::string& table, Config& config) {
  Config::keys(config, [&]<class T>(const char* name, T& member, const rt::KeySpec& spec, auto&&...) {
    if constexpr (!std::is_same_v<T, rt::Vector3>) {
      if ((spec.marks & rt::kLive) == 0) return;
      builder.parameter(group, key_path(table, name), [&member, spec](double value) {
        member = rt::from_written<T>(value, spec);
        return Status::ok;
      });
    }
  });
}

}  // namespace sortie::firmware
