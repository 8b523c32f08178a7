// SPDX-License-Identifier: BSD-3-Clause
// Messages about run-time parameters: the change as a log holds it, the request from outside, and what is in
// force.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/channels.hpp"
#include "drivers/siphash.hpp"
#include "rt/parameter.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// A request to change a parameter. On decoding `name` points into the message.
struct SetParameter {
  std::int64_t utime{};    ///< us UTC of the sender's clock
  std::int64_t session{};  ///< of the run that is meant
  std::int64_t sender{};   ///< comes back with the answer
  std::int64_t counter{};  ///< above all that the run has taken: a repeated datagram is stale
  std::string_view name;
  double value{};
};

/// One parameter as it stands now.
struct ParameterInForce {
  std::string name;
  std::string unit;
  double value{};
  double low{};
  double high{};
};

/// What became of a request.
struct ParameterAnswer {
  std::int64_t sender{};
  std::int64_t counter{};
  std::int32_t status{};  ///< Status as a number; ok: admitted
};

/// parameters_t.
struct ParametersMessage {
  std::int64_t utime{};
  std::int64_t session{};
  std::int64_t counter{};  ///< highest that was taken
  std::string scene;
  bool remote{};  ///< requests are listened to
  bool keyed{};   ///< and need a tag
  std::vector<ParameterInForce> parameters;
  std::vector<ParameterAnswer> answers;
};

/// Longest set_parameter_t that is looked at.
inline constexpr std::size_t kMaxSetParameterBytes = 7 * 8 + 4 + rt::kMaxParameterName + 1;

/// The change of a log, with its sequence number. No heap. Decoding: as the samples of wire.hpp; a name that
/// no parameter can have is `malformed`.
[[nodiscard]] Status encode(const rt::ParameterChange& change, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::ParameterChange& change,
                            std::int64_t& seq) noexcept;

/// A request with its tag; `key` null: tag 0. No heap. Decoding: `bad_checksum` for another type of message,
/// `malformed` for wrong lengths, `disconnected` when `key` is given and the tag is not its.
[[nodiscard]] Status encode(const SetParameter& request, const SipKey* key, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, const SipKey* key,
                            SetParameter& request) noexcept;

/// For threads that are not real-time: decoding allocates, but never more than the message is long.
[[nodiscard]] Status encode(const ParametersMessage& parameters, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, ParametersMessage& parameters);

}  // namespace sortie::drivers
