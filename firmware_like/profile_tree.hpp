// SPDX-License-Identifier: BSD-3-Clause
// The parsed file behind a Profile, for the profile's own source files only.
#pragma once

#include <toml++/toml.h>

#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// Root table of a profile, overrides applied.
struct Profile::Tree {
  toml::table root;
};

}  // namespace sortie::firmware
