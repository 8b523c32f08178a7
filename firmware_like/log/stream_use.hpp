// SPDX-License-Identifier: BSD-3-Clause
// What became of the samples of each stream: a run that made use of none of them has the wrong scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sortie::firmware {

class Runtime;

/// The samples of one input channel of a scene.
struct StreamUse {
  std::string channel;
  std::uint64_t there{};      ///< in the log, or pushed by the driver
  std::uint64_t offered{};    ///< of these, to the stream, by a job that was due
  std::uint64_t taken{};      ///< of these, by jobs
  std::uint64_t malformed{};  ///< of another type, or damaged
  std::uint64_t too_large{};  ///< more than a slot of the stream's pool holds
  std::uint64_t no_room{};    ///< all slots were full
};

/// What the drivers of a live or simulated run pushed, without what still waits. After the run.
std::vector<StreamUse> pushed_streams(const Runtime& runtime);

/// One line, with the cure, for each stream that had samples of which nothing was used: all refused by the
/// stream, all refused by the task (VehicleBuilder::uses), or with `must_be_offered` none consumed. Empty:
/// all is well. The rule: a run that used nothing of a stream says so and ends with 1; to be refused all the
/// same is no result.
std::vector<std::string> unused_streams(const Runtime& runtime, const std::vector<StreamUse>& uses,
                                        bool must_be_offered);

/// The same for the channels of a log that a scene has no stream for. `chosen`: the scene was chosen for this
/// log, which names none; then each of them counts. Otherwise, in a what-if, only a log of which nothing at
/// all is used.
std::vector<std::string> channels_without_stream(const std::string& scene, const std::vector<StreamUse>& uses,
                                                 const std::vector<std::string>& channels, bool chosen);

}  // namespace sortie::firmware
