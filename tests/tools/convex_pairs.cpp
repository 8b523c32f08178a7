// SPDX-License-Identifier: BSD-3-Clause
// convex_pairs COUNT > FILE: what rt/convex says about COUNT random shallow pairs of bodies, a line each.
// convex_pairs COUNT --against FILE: the same, compared with what another processor or another libccd said.
#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "rt/convex/query.hpp"
#include "tests/rt/convex_oracle.hpp"

namespace {

using sortie::rt::convex::Convex;
using sortie::rt::convex::QueryResult;

struct Difference {
  long asked{};   // pairs that libccd was asked about
  long bits{};    // depth or normal differ in at least one bit
  long states{};  // judged differently: free, touching, penetrating
  long depths{};  // depth differs by more than a micrometre
  double depth_m{};
  double normal{};  // largest distance of the two unit vectors
};

QueryResult nth_answer(sortie::rt::convex::test::Draw& draw, long i) {
  namespace test = sortie::rt::convex::test;
  Convex a = i % 4 == 0 ? test::any_box(draw) : test::any_track(draw);
  Convex b = test::any_box(draw);
  b.R_world_body = sortie::rt::to_matrix(draw.turn());
  const double overlap = draw.within(-0.002, 0.004);
  test::put_shallow(draw, a, b, overlap);
  return sortie::rt::convex::query(a, b);
}

bool compare(FILE* other, const QueryResult& q, Difference& sum) {
  unsigned state = 0;
  unsigned calls = 0;
  double depth = 0;
  double x = 0;
  double y = 0;
  double z = 0;
  if (std::fscanf(other, "%u %u %la %la %la %la", &state, &calls, &depth, &x, &y, &z) != 6) return false;
  if (q.support_calls > 0) ++sum.asked;
  if (state != static_cast<unsigned>(q.state)) ++sum.states;
  const double turned = std::hypot(x - q.normal.x, y - q.normal.y, z - q.normal.z);
  if (depth != q.depth_m || turned != 0.0) ++sum.bits;
  if (std::abs(depth - q.depth_m) > 1e-6) ++sum.depths;
  sum.depth_m = std::max(sum.depth_m, std::abs(depth - q.depth_m));
  sum.normal = std::max(sum.normal, turned);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const long count = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 0;
  const bool comparing = argc == 4 && std::strcmp(argv[2], "--against") == 0;
  if (count <= 0 || (argc != 2 && !comparing)) {
    std::fprintf(stderr, "usage: convex_pairs COUNT [--against FILE]\n");
    return 2;
  }
  FILE* other = comparing ? std::fopen(argv[3], "r") : nullptr;
  if (comparing && other == nullptr) {
    std::fprintf(stderr, "convex_pairs: cannot read %s\n", argv[3]);
    return 3;
  }
  sortie::rt::convex::test::Draw draw(17);
  Difference sum;
  for (long i = 0; i < count; ++i) {
    const QueryResult q = nth_answer(draw, i);
    if (!comparing) {
      std::printf("%u %u %a %a %a %a\n", static_cast<unsigned>(q.state), q.support_calls, q.depth_m,
                  q.normal.x, q.normal.y, q.normal.z);
    } else if (!compare(other, q, sum)) {
      std::fprintf(stderr, "convex_pairs: %s ends at pair %ld\n", argv[3], i);
      return 3;
    }
  }
  if (comparing) {
    std::printf(
        "%ld pairs, libccd asked about %ld: %ld differ in bits, %ld in their state, %ld in depth by over 1 "
        "um; "
        "depth by at most %.3g m, normal by at most %.3g\n",
        count, sum.asked, sum.bits, sum.states, sum.depths, sum.depth_m, sum.normal);
  }
  return 0;
}
