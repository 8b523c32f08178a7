// SPDX-License-Identifier: BSD-3-Clause
// The fault that --fault plants in a replay, to show that a check can fail.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rt/executive.hpp"

namespace sortie::firmware {

/// One job of a task, and perhaps a byte of its output.
struct NamedFault {
  std::uint32_t task{};  ///< its number in the executive
  rt::Tick tick{};
  std::optional<std::uint32_t> byte{};  ///< within the output
};

/// Reads "task@tick" or, where `has_bytes`, "task.byte@tick". Throws ProfileError that shows the form.
NamedFault parse_fault(const rt::Executive& executive, const std::string& text, bool has_bytes);

/// What was to show that it can fail must not pass because nothing was changed: throws InputError (exit code
/// 2).
[[noreturn]] void refuse_unmet_fault(const std::string& text);

}  // namespace sortie::firmware
