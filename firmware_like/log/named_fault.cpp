// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/named_fault.hpp"

#include <charconv>
#include <string_view>

#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {
namespace {

/// The whole of a text as a number.
template <class T>
bool read_whole(std::string_view text, T& value) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc{} && read.ptr == text.data() + text.size();
}

}  // namespace

NamedFault parse_fault(const rt::Executive& executive, const std::string& text, bool has_bytes) {
  const std::string_view whole = text;
  const std::size_t at = whole.find('@');
  const std::string_view target = whole.substr(0, at);
  const std::size_t dot = has_bytes ? target.find('.') : std::string_view::npos;
  NamedFault fault;
  bool good = at != std::string_view::npos && read_whole(whole.substr(at + 1), fault.tick);
  if (good && dot != std::string_view::npos) good = read_whole(target.substr(dot + 1), fault.byte.emplace());
  for (; good && fault.task < executive.task_count(); ++fault.task) {
    const rt::TaskBase& task = executive.task(fault.task);
    if (target.substr(0, dot) != task.name()) continue;
    if (fault.byte && *fault.byte >= task.output_bytes()) {
      throw ProfileError("--fault " + text + ": the output of this task has " +
                         std::to_string(task.output_bytes()) + " bytes, 0 is the first");
    }
    return fault;
  }
  throw ProfileError("--fault " + text + ": write task@tick" + (has_bytes ? " or task.byte@tick" : "") +
                     " with a task of this scene, e.g. odometry@1200");
}

void refuse_unmet_fault(const std::string& text) {
  throw InputError("--fault " + text + ": this task has no job at that tick of the replay", 2);
}

}  // namespace sortie::firmware
