// SPDX-License-Identifier: BSD-3-Clause
// What a source of commands has asked for, and whether a stop has used it up.
#pragma once

#include <cstdint>

namespace sortie::drivers {

/// One source's requests. Its commands carry the number of its newest request (rt::DriveCommand::asked): a
/// request is a number that has risen. That its motors are enabled again, or a speed is wanted again, is
/// none, for the robot itself takes that back and gives it again as it likes.
///
/// A stop uses up what was asked before it; each source has a latch of its own, so that nobody's request
/// revives another's. 8 bytes, plain.
class RequestLatch {
 public:
  /// `spent`: whether something must be asked for before anything is obeyed at all.
  explicit RequestLatch(bool spent = true) noexcept : spent_(spent) {}

  /// A command of the source. `counts`: a request may count now; one that may not is used up at once. True:
  /// it is a new request that counts. Numbers begin at 0 with the program, so that the very first command may
  /// bring a request: who polls may have missed those before it.
  bool hear(std::uint32_t asked, bool counts) noexcept {
    const bool anew = asked > asked_ && counts;
    asked_ = asked;
    if (anew) spent_ = revives_ = false;
    return anew;
  }
  /// A stop that nobody asked for. `revives`: revive() may take it back.
  void spend(bool revives = false) noexcept {
    revives_ = revives && (!spent_ || revives_);
    spent_ = true;
  }
  /// The drives start again by themselves: what a stop has used up that may be taken back holds again.
  void revive() noexcept {
    if (revives_) spent_ = false;
    revives_ = false;
  }
  /// Nothing it says is to be obeyed until it asks anew.
  bool spent() const noexcept { return spent_; }

 private:
  std::uint32_t asked_{};
  bool spent_;
  bool revives_{};
};

}  // namespace sortie::drivers
