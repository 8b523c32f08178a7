// SPDX-License-Identifier: BSD-3-Clause
// The maps that a replay ends with, as files.
#pragma once

#include <ostream>
#include <string>

#include "firmware_like/log/replay.hpp"

namespace sortie::toolchain {

/// The local map's voxels as a PLY. Throws InputError where the scene keeps none; `log` is its name in it.
void export_ply(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out);

/// The map of surfaces of part locate, for `run --map`. Throws InputError where the scene makes none.
void export_surfels(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out);

/// The targets of part recognise, for `run --targets`. Throws InputError where the scene makes none.
void export_targets(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out);

/// The height images of part recognise_images, for `run --images`. Throws InputError where the scene makes
/// none.
void export_images(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out);

/// The cloud of part cloud, for `run --map` of another robot. Throws InputError where the scene makes none.
void export_cloud(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out);

}  // namespace sortie::toolchain
