// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/stream_use.hpp"

#include <algorithm>

#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

namespace {

// The first samples of a run may come before what they need, a pose for a scan: fewer say nothing.
constexpr std::uint64_t kEnough = 10;

constexpr const char* kCure =
    "; take a scene that is made for such data (`sortie scenes`), or correct the sensor; --accept-unused "
    "where a replay means it";

std::string reasons(const StreamUse& use) {
  std::string text;
  const auto add = [&text](std::uint64_t count, const char* reason) {
    if (count != 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  };
  add(use.malformed, "of another type or damaged");
  add(use.too_large, "larger than its [limits] allow");
  add(use.no_room, "without room in its stream");
  return text;
}

// Whether no task of those that should has used a sample; false where none should.
bool idle(const VehicleBuilder::Counters& uses, const std::string& channel) {
  bool some = false;
  for (const auto& [name, used] : uses) {
    if (name != channel) continue;
    if (used() != 0) return false;
    some = true;
  }
  return some;
}

}  // namespace

std::vector<StreamUse> pushed_streams(const Runtime& runtime) {
  std::vector<StreamUse> uses;
  for (const auto& port : runtime.parts().ports()) {
    // What still waits no job has seen, so nobody can have used it: after a run that was stopped, that may be
    // all.
    const std::uint64_t waiting = port->stream().waiting();
    const std::uint64_t taken = static_cast<std::uint64_t>(port->admitted()) - waiting;
    const std::uint64_t refused = port->stream().refused();
    const std::uint64_t offered = taken == 0 && waiting != 0 ? 0 : taken + refused;
    uses.push_back({port->channel(), taken + waiting + refused, offered, taken, 0, 0, refused});
  }
  return uses;
}

std::vector<std::string> unused_streams(const Runtime& runtime, const std::vector<StreamUse>& uses,
                                        bool must_be_offered) {
  const std::string& scene = runtime.profile().name();
  std::vector<std::string> lines;
  for (const StreamUse& use : uses) {
    std::string what;
    if (use.offered == 0) {
      if (must_be_offered && use.there != 0)
        what = "none of " + std::to_string(use.there) + " samples was consumed by scene " + scene;
    } else if (use.taken == 0) {
      what = std::to_string(use.offered) + " of " + std::to_string(use.offered) +
             " samples were refused by scene " + scene + " (" + reasons(use) + ")";
    } else if (use.taken >= kEnough && idle(runtime.parts().uses(), use.channel)) {
      what = "scene " + scene + " took " + std::to_string(use.taken) +
             " samples, and its tasks could use none of them (the counters say why)";
    }
    if (what.empty()) continue;
    lines.push_back("channel " + use.channel + ": " + what + kCure);
  }
  return lines;
}

std::vector<std::string> channels_without_stream(const std::string& scene, const std::vector<StreamUse>& uses,
                                                 const std::vector<std::string>& channels, bool chosen) {
  const bool some =
      std::any_of(uses.begin(), uses.end(), [](const StreamUse& use) { return use.there != 0; });
  std::vector<std::string> lines;
  for (const std::string& channel : channels) {
    if (some && !chosen) break;
    lines.push_back("channel " + channel + ": no task of scene " + scene + " takes it" + kCure);
  }
  return lines;
}

}  // namespace sortie::firmware
