// SPDX-License-Identifier: BSD-3-Clause
// Where changes of run-time parameters come in: from the profile's script, and as requests.
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware_like/link/request_desk.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// What became of the changes that were asked for.
struct ParameterDeskCounters : ReceptionCounters {
  std::uint64_t unknown{};  ///< no such parameter
  std::uint64_t stale{};    ///< repeated, or overtaken by a later one
  SORTIE_FIELDS(admitted, unknown, not_finite, out_of_range, full, malformed, bad_tag, wrong_session,
                wrong_time, stale)
};

/// The desk of changes. None stands for another, so none takes another's place: what finds no room is
/// refused. Each is judged once, whatever comes of it, and has an answer of its own; a repeat has had its.
/// One thread calls set() and take(); any thread may read the rest.
template <>
class RequestDesk<drivers::SetParameter> : public RequestReception<ParameterDeskCounters> {
 public:
  using Kind = RequestKind<drivers::SetParameter>;
  static constexpr const char* kCounters = "parameters_";  ///< before their names in a result

  /// `runtime` outlives the desk.
  explicit RequestDesk(Runtime& runtime) : runtime_(runtime) {}

  /// True when requests are taken; the script's changes always are.
  bool wanted() const { return runtime_.parameter_access().remote; }
  /// True when there is anything to change.
  bool counts() const { return !runtime_.parts().parameters().all.empty(); }
  /// Judges the bytes of a message and hands the change in.
  void take(std::span<const std::uint8_t> message, const RequestContext& context);
  /// Nothing waits here.
  void hand_in(rt::Nanoseconds) {}

  /// Hands in one change. Status: ok (it is in the log and will be applied by the group's next job),
  /// not_supported (no such parameter), not_finite, out_of_range, full. All counted.
  Status set(std::string_view name, double value, rt::Nanoseconds now_ns);

  /// Fills in the highest counter that was taken, and the newest answers.
  void describe(drivers::ParametersMessage& message) const;
  /// That counter: it has risen whenever there are new answers.
  std::int64_t newest() const;

 private:
  Status hand_in(std::string_view name, double value, rt::Nanoseconds now_ns);

  Runtime& runtime_;
  std::int64_t newest_{};
  RequestAnswers answers_;
};

}  // namespace sortie::firmware
