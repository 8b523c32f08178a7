// SPDX-License-Identifier: BSD-3-Clause
// What the part `cloud` lets a later part of its group see.
#pragma once

#include "mapping/registration/cloud_match.hpp"

namespace sortie::firmware {

/// Offered by `cloud`. A task of the same group, behind it in the table, may read the cloud in its job.
struct CloudAccess {
  mapping::SensedCloud cloud;
  std::uint64_t views{};  ///< that are in it
  bool held{};            ///< set by the reader: the cloud stays as it is, views are left out
  bool renew{};           ///< set by the reader: the next job begins with an empty cloud
};

}  // namespace sortie::firmware
