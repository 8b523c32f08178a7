// SPDX-License-Identifier: BSD-3-Clause
// The latest value with longer programs in every interleaving: millions of executions each.
#include <catch2/catch.hpp>

#include "rt/latest_value.hpp"
#include "tests/rt/queue_latest_model.hpp"

namespace sortie::rt::test {

TEST_CASE("the latest value holds in any interleaving of three writes and two readers") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = many_readers<LatestValue<Tracked, 2, Modelled>>(3, {1, 1}, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 1'000'000);
  CHECK(result.failures == 0);
}

TEST_CASE("the latest value holds in any interleaving of five writes and five reads") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = many_readers<LatestValue<Tracked, 1, Modelled>>(5, {5}, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 1'000'000);
  CHECK(result.failures == 0);
}

}  // namespace sortie::rt::test
