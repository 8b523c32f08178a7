// SPDX-License-Identifier: BSD-3-Clause
// Sequences from a seed.
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "hil/random.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace sortie::bench {

namespace {

double hostile_value(hil::Random& random) {
  using Limits = std::numeric_limits<double>;
  const double sign = random.chance(0.5) ? 1.0 : -1.0;
  switch (random.bits() % 16) {
    case 0:
      return std::nan("");
    case 1:
      return sign * Limits::infinity();
    case 2:
      return sign * Limits::denorm_min();
    case 3:
      return sign * Limits::max();
    case 4:
      return sign * Limits::min();
    case 5:
      return -0.0;
    case 6:
      return std::bit_cast<double>(random.bits());  // any pattern, NaNs with a load among them
    case 7:
      return sign * random.uniform() * 1e18;
    case 8:
      return sign * random.uniform() * 1e-18;
    case 9:
      return sign * std::ldexp(1.0, static_cast<int>(random.bits() % 80));
    case 10:
      return std::floor(random.uniform(-4.0, 5.0));
    case 11:
      return std::nextafter(sign, 2.0 * sign);
    default:
      return random.uniform(-100.0, 100.0);
  }
}

std::int64_t hostile_step(hil::Random& random, std::int64_t period_ns) {
  using Limits = std::numeric_limits<std::int64_t>;
  switch (random.bits() % 10) {
    case 0:
      return 0;
    case 1:
      return -period_ns;
    case 2:
      return 1;
    case 3:
      return static_cast<std::int64_t>(random.bits());
    case 4:
      return Limits::max();
    case 5:
      return Limits::min();
    case 6:
      return 31'557'600'000'000'000;  // a year
    case 7:
      return -3'600'000'000'000;  // an hour back
    default:
      return static_cast<std::int64_t>(random.bits() % 64) * period_ns;
  }
}

}  // namespace

std::vector<CampaignOp> draw_sequence(const CampaignModule& module, std::uint64_t seed,
                                      std::uint64_t number) {
  hil::Random random(seed, number);
  std::vector<CampaignOp> ops(1 + static_cast<std::size_t>(random.bits() % module.longest));
  // A quarter of the sequences is calm: else nothing would get far into the state.
  constexpr double kShares[4] = {0.0, 0.02, 0.1, 0.5};
  const double hostile = kShares[random.bits() % 4];
  const double size = random.chance(0.5) ? 1.0 : 0.1;
  CampaignOp level;  // what calm values lie about
  for (double& value : level.value) value = random.uniform(-1.0, 1.0);
  for (std::size_t i = 0; i < ops.size(); ++i) {
    CampaignOp& op = ops[i];
    if (i > 0 && random.chance(0.3 * hostile)) {  // a stuck device
      op = ops[i - 1];
      op.step_ns = random.chance(0.5) ? 0 : module.period_ns;
      continue;
    }
    op.kind = static_cast<std::uint32_t>(random.bits() % module.kinds);
    op.step_ns = random.chance(hostile) ? hostile_step(random, module.period_ns) : module.period_ns;
    for (std::size_t k = 0; k < kCampaignValues; ++k) {
      const double away = size * random.uniform(-1.0, 1.0);
      const double calm = (1.0 - size) * level.value[k] + away;
      op.value[k] = random.chance(hostile) ? hostile_value(random) : calm;
    }
  }
  for (std::size_t i = 1; i < ops.size(); ++i) {  // a bus that changes the order
    if (random.chance(0.2 * hostile)) std::swap(ops[i - 1], ops[i]);
  }
  return ops;
}

}  // namespace sortie::bench
