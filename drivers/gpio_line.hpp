// SPDX-License-Identifier: BSD-3-Clause
// One input line of a board (Linux GPIO character device, version 2): an emergency stop's contact.
#pragma once

#include <cstdint>
#include <string>

#include "rt/keys.hpp"
#include "rt/status.hpp"

namespace sortie::drivers {

/// Which line, and which level is "closed".
struct GpioLineConfig {
  std::string chip = "/dev/gpiochip0";
  std::uint32_t line = 0;
  bool active_low = false;

  /// `chip` decides whether there is a line at all.
  SORTIE_KEYS(c, key) {
    key("gpio_line", c.line, {0, 1023, "", "line of the emergency stop's contact on that chip"});
    key("gpio_active_low", c.active_low,
        {"pressed is the low level, as where a broken wire counts as pressed"});
  }
};

/// An input line. After open() no call allocates or blocks; a reading is one system call. One thread.
class GpioLine {
 public:
  GpioLine() = default;
  ~GpioLine() { close(); }
  GpioLine(const GpioLine&) = delete;
  GpioLine& operator=(const GpioLine&) = delete;

  /// Status: ok; not_supported (no GPIO here); disconnected (no such chip or line, in use, not allowed).
  /// `problem` then says what is wrong and the cure.
  [[nodiscard]] Status open(const GpioLineConfig& config, std::string& problem);
  void close() noexcept;

  /// Status: ok; disconnected: the line cannot be read (`active` is unchanged).
  [[nodiscard]] Status read(bool& active) const noexcept;
  bool is_open() const noexcept { return descriptor_ >= 0; }

 private:
  int descriptor_{-1};
};

}  // namespace sortie::drivers
