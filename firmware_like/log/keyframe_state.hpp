// SPDX-License-Identifier: BSD-3-Clause
// A replay's state at one tick, to a keyframe and back.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "firmware_like/log/keyframes.hpp"
#include "firmware_like/log/log_feed.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// What keyframes of this log and this runtime must carry.
KeyframeHead keyframe_head(const LogFile& log, const Runtime& runtime);

/// Throws InputError (exit code 2), naming the cure, unless `file` was made of what `wanted` describes.
void refuse_foreign(const KeyframeFile& file, const KeyframeHead& wanted, const std::string& log_path);

/// The whole state before the jobs of `tick`. Throws InputError when something in it cannot be archived,
/// naming the class and the cure.
std::vector<std::uint8_t> save_state(Runtime& runtime, LogFeed& feed, rt::Tick tick);

/// Takes a state that save_state() gave. Throws InputError when it is of another runtime; this one is then of
/// no more use.
void restore_state(std::span<const std::uint8_t> state, Runtime& runtime, LogFeed& feed, rt::Tick tick);

}  // namespace sortie::firmware
