// SPDX-License-Identifier: BSD-3-Clause
// Truth of the inertial sensor and the encoders, as a custom_t on its own channel.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/channels.hpp"
#include "rt/sensor_truth.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Names and types of the numbers in the message, in their order.
inline constexpr std::string_view kSensorTruthFields =
    "stamp_ns:i64,gyr_rad_s[0]:f64,gyr_rad_s[1]:f64,gyr_rad_s[2]:f64,acc_m_s2[0]:f64,acc_m_s2[1]:f64,acc_m_"
    "s2[2]:f64,"
    "gyr_bias_rad_s[0]:f64,gyr_bias_rad_s[1]:f64,gyr_bias_rad_s[2]:f64,acc_bias_m_s2[0]:f64,acc_bias_m_s2[1]:"
    "f64,"
    "acc_bias_m_s2[2]:f64,belt_left_m:f64,belt_right_m:f64,ground_left_m:f64,ground_right_m:f64";

/// Room for a message.
inline constexpr std::size_t kMaxSensorTruthBytes = 768;

/// Status: ok, full (`out` is too small; `size` is then 0). `seq` counts the records.
[[nodiscard]] Status encode(const rt::SensorTruth& truth, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept;
/// Status: ok; bad_checksum (another type); malformed (other fields or lengths). `truth` is unchanged unless
/// ok.
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, rt::SensorTruth& truth) noexcept;

}  // namespace sortie::drivers
