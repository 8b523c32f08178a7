// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/descriptor_parts.hpp"

#include <cmath>
#include <cstdlib>

namespace sortie::bench {
namespace {

using D = mapping::SegmentDescriptor;

struct DescriptorPart {
  const char* name;
  unsigned first, bytes;
};
constexpr DescriptorPart kParts[] = {
    {"all", 0, D::kSteps},           {"longest size", D::kSize, 1},     {"middle size", D::kSize + 1, 1},
    {"least size", D::kSize + 2, 1}, {"uprightness", D::kUpright, 2},   {"third moments", D::kThird, 2},
    {"fill", D::kFill, 1},           {"heights", D::kHeight, D::kBins}, {"distances", D::kRadius, D::kBins}};

double steps_apart(const DescriptorPart& part, const SpokenSegment& a, const SpokenSegment& b) {
  int sum = 0;
  for (unsigned i = part.first; i < part.first + part.bytes; ++i)
    sum += std::abs(a.descriptor.step[i] - b.descriptor.step[i]);
  return sum;
}

struct Mean {
  double sum{}, count{};
  void add(double value) {
    sum += value;
    count += 1.0;
  }
  double tenths() const { return count > 0.0 ? std::round(10.0 * sum / count) / 10.0 : 0.0; }
};

}  // namespace

Json part_rows(const std::vector<HallPairs>& halls, const std::string& policy) {
  Json rows = Json::array();
  for (const DescriptorPart& part : kParts) {
    Mean same, different, turned;
    std::vector<JudgedPair> pairs;
    for_pairs(halls, [&](const SpokenSegment& a, const SpokenSegment& b, SegmentTruth truth, std::size_t h) {
      const double apart = steps_apart(part, a, b);
      pairs.push_back({apart, truth == SegmentTruth::same, h});
      (truth == SegmentTruth::same ? same : different).add(apart);
    });
    for (const HallPairs& hall : halls) {
      const std::size_t columns = hall.turned.segments.size();
      for (std::size_t i = 0; i < hall.turned_truth.size(); ++i) {
        if (hall.turned_truth[i] == SegmentTruth::same)
          turned.add(
              steps_apart(part, hall.visit[0].segments[i / columns], hall.turned.segments[i % columns]));
      }
    }
    rows.push_back({policy, part.name, part.bytes, std::round(1000 * RocCurve(pairs).area()) / 1000,
                    same.tenths(), turned.tenths(), different.tenths()});
  }
  return rows;
}

}  // namespace sortie::bench
