// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/kept_cloud.hpp"

#include "firmware_like/parts/named_map.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "mapping/registration/cloud_file.hpp"

namespace sortie::firmware {
namespace {

[[noreturn]] void refuse_cloud(const KeptMap& map, const mapping::CloudFileResult& result) {
  throw InputError("--map " + map.path + ": byte " + std::to_string(result.byte) + ": " + result.why +
                       "; make it again with `sortie export cloud LOG -o FILE`",
                   3);
}

}  // namespace

KeptCloud load_kept_cloud(VehicleBuilder& builder) {
  KeptCloud kept;
  const KeptMap* map = named_map(builder, "join");
  if (map == nullptr) return kept;
  const mapping::CloudFileResult head = mapping::read_cloud_head(map->bytes);
  if (head.fault != mapping::CloudFileFault::none) refuse_cloud(*map, head);
  kept.sensor = head.sensor;
  kept.layer = std::make_unique<mapping::SightLayer>(head.config, builder.arena());
  if (builder.arena().refused() != 0) return kept;  // its memory is still being measured
  const mapping::CloudFileResult result = mapping::load_cloud(map->bytes, *kept.layer);
  if (result.fault != mapping::CloudFileFault::none) refuse_cloud(*map, result);
  return kept;
}

}  // namespace sortie::firmware
