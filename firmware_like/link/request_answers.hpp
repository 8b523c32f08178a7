// SPDX-License-Identifier: BSD-3-Clause
// What became of the newest request of each sender, for the acknowledgement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/wire_answers.hpp"

namespace sortie::firmware {

/// One answer a sender, of bounded number; whoever was answered longest ago makes room. A stop's answers have
/// a list of their own, so that no crowd of other senders can push them out.
class RequestAnswers {
 public:
  static constexpr std::size_t kMostSenders = 16;  ///< of either list

  /// Notes an answer. One that is older than what its sender has had already is dropped: whoever plays a
  /// request again must not turn its sender's answer into a refusal.
  void note(const drivers::RequestAnswer& answer, bool stop) {
    std::vector<drivers::RequestAnswer>& list = stop ? stops_ : others_;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].sender != answer.sender) continue;
      if (list[i].counter >= answer.counter) return;
      list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    }
    if (list.size() == kMostSenders) list.erase(list.begin());
    list.push_back(answer);
  }
  /// All of them, those of stops first.
  std::vector<drivers::RequestAnswer> all() const {
    std::vector<drivers::RequestAnswer> answers = stops_;
    answers.insert(answers.end(), others_.begin(), others_.end());
    return answers;
  }

 private:
  std::vector<drivers::RequestAnswer> stops_;
  std::vector<drivers::RequestAnswer> others_;
};

}  // namespace sortie::firmware
