// SPDX-License-Identifier: BSD-3-Clause
#include "tests/planner/posture_judge_rests.hpp"

namespace sortie::planner {

TEST_CASE("postures are those that the plant comes to rest in", "[heavy]") { judge_rests(1, 120); }

}  // namespace sortie::planner
