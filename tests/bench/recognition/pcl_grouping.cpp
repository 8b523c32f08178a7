// SPDX-License-Identifier: BSD-3-Clause
#ifdef SORTIE_PEER_PCL
#include <pcl/point_types.h>
#include <pcl/recognition/cg/geometric_consistency.h>
#endif

#include "rt/posix/clock.hpp"
#include "tests/bench/recognition/set_peers.hpp"

namespace sortie::bench {

#ifdef SORTIE_PEER_PCL
bool pcl_grouping(const std::vector<mapping::SweptPair>& pairs, double eps_m, int least, Chosen& chosen,
                  double& ms) {
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  const Cloud::Ptr segments(new Cloud), targets(new Cloud);
  const pcl::CorrespondencesPtr list(new pcl::Correspondences);
  const auto put = [](Cloud& cloud, std::size_t at, const mapping::PlaceCm& p) {
    if (cloud.size() <= at) cloud.resize(at + 1);
    cloud[at] = pcl::PointXYZ(0.01f * static_cast<float>(p.x), 0.01f * static_cast<float>(p.y),
                              0.01f * static_cast<float>(p.z));
  };
  for (const mapping::SweptPair& p : pairs) {
    put(*segments, p.pair.segment, p.segment);
    put(*targets, p.pair.target, p.target);
    list->emplace_back(p.pair.segment, p.pair.target, 0.0f);
  }
  const auto begin = rt::posix::thread_cpu_now();
  pcl::GeometricConsistencyGrouping<pcl::PointXYZ, pcl::PointXYZ> grouping;
  grouping.setGCSize(eps_m);
  grouping.setGCThreshold(least);
  grouping.setInputCloud(segments);
  grouping.setSceneCloud(targets);
  grouping.setModelSceneCorrespondences(list);
  std::vector<pcl::Correspondences> groups;
  grouping.cluster(groups);
  ms = 1e-6 * static_cast<double>(rt::posix::thread_cpu_now() - begin);
  chosen.clear();
  const pcl::Correspondences* largest = nullptr;
  for (const auto& group : groups) {
    if (largest == nullptr || group.size() > largest->size()) largest = &group;
  }
  for (std::uint32_t i = 0; largest != nullptr && i < pairs.size(); ++i) {
    for (const pcl::Correspondence& c : *largest) {
      if (c.index_query == pairs[i].pair.segment && c.index_match == pairs[i].pair.target)
        chosen.push_back(i);
    }
  }
  return true;
}
#else
bool pcl_grouping(const std::vector<mapping::SweptPair>&, double, int, Chosen&, double&) { return false; }
#endif

}  // namespace sortie::bench
