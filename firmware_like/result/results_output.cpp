// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/result/results_output.hpp"

#include <unistd.h>

#include <iostream>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

void print_results(const Results& results, bool json, const std::vector<std::string>* judged) {
  if (!json) return print_table(std::cout, results, wants_colour(STDOUT_FILENO));
  Json object = to_json(results);
  if (judged != nullptr) {
    object["passed"] = judged->empty();
    object["failures"] = *judged;
  }
  std::cout << object.dump(2) << "\n";
}

void print_failures(const std::vector<std::string>& failures, bool json) {
  for (const std::string& failure : failures) (json ? std::cerr : std::cout) << "FAILED  " << failure << "\n";
}

}  // namespace sortie::firmware
