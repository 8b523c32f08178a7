// SPDX-License-Identifier: BSD-3-Clause
// What the doctor says about a board: one finding for each thing that real time depends on, with its cure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sortie::firmware {

class Json;

/// How a thing stands. The order is that of getting worse, `unknown` apart.
enum class Health : std::uint8_t {
  good,     ///< nothing to do
  warn,     ///< works, with more latency than the board could have
  bad,      ///< real time is not to be had like this
  unknown,  ///< the board does not tell
};

/// "good", "warn", "bad", "unknown".
const char* to_string(Health health);

/// One thing that was looked at.
struct Finding {
  std::string name;   ///< fixed, snake_case: clock_source
  std::string value;  ///< what was found, for a person
  Health verdict{Health::unknown};
  std::string why;     ///< one line: what it does to a run
  std::string cure{};  ///< a command line; empty when there is nothing to cure
};

/// All findings about one machine.
struct DoctorReport {
  bool present{};       ///< false: nobody looked, and results do not mention it
  std::string machine;  ///< whose verdict this is
  std::string note;     ///< instead of findings: why there are none; or what is special about them
  std::vector<Finding> findings;

  /// The worst of the findings; unknown when there are none.
  Health verdict() const;
  /// One line: "bad: memory_lock, realtime_priority; 5 to improve, 9 good".
  std::string summary() const;
};

/// Object with the keys verdict, summary, machine, findings[]{name, value, verdict, why, cure}; and `note`.
Json to_json(const DoctorReport& report);

/// Reads back what to_json wrote. Throws std::runtime_error naming what is wrong.
DoctorReport doctor_from_json(const Json& object);

}  // namespace sortie::firmware
