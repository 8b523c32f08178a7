// SPDX-License-Identifier: BSD-3-Clause
// Who asks for motors in a test: every step from off to on is a request, as halt and release make one.
#pragma once

#include <cstdint>

namespace sortie::hil::test {

/// Of one source. Call it with each command, once its flags are set.
class Asker {
 public:
  template <class Command>
  void operator()(Command& command) {
    const bool on = command.flags != 0;
    if (on && !on_) ++asked_;
    on_ = on;
    command.asked = asked_;
  }
  /// Another program that commands: its numbers begin anew.
  void begin_anew() { *this = Asker(); }

 private:
  std::uint32_t asked_{};
  bool on_{true};  // whoever begins with on has not asked
};

}  // namespace sortie::hil::test
