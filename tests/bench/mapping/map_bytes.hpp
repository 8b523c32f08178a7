// SPDX-License-Identifier: BSD-3-Clause
// What a local map takes of its pools.
#pragma once

#include "tests/mapping/owned_map.hpp"

namespace sortie::bench {

/// Bytes of all pools at their high water, the window's table apart.
template <class Map>
double most_map_bytes(const Map& map) {
  const auto& output = map.grid().output();
  const auto voxel =
      static_cast<double>(sizeof(mapping::Centroid) +
                          (Map::kNormals ? sizeof(mapping::SurfaceNormal) + sizeof(mapping::NormalSums) : 0));
  const double voxels = output.most_chunks * mapping::Block::kChunk * voxel;
  const double nodes = map.segmenter().graph().most_in_use() *
                       static_cast<double>(sizeof(mapping::FragmentNode) + sizeof(mapping::NodeWork) +
                                           sizeof(mapping::SegmentComponent) + 2);
  double blocks =
      output.most_blocks * static_cast<double>(sizeof(mapping::Block) + sizeof(mapping::BlockWork) + 4);
  if (Map::kNormals) blocks += output.most_blocks * static_cast<double>(sizeof(mapping::NormalWork) + 4);
  return voxels + nodes + blocks;
}

}  // namespace sortie::bench
