// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/kept_maps.hpp"

#include <algorithm>

#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "mapping/recognition/image_file.hpp"
#include "mapping/recognition/target_file.hpp"
#include "mapping/registration/cloud_file.hpp"

namespace sortie::firmware {
namespace {

using mapping::SurfelMapFault;
using mapping::SurfelMapHead;
using mapping::SurfelMapResult;

/// What a map is called where it is asked for. Texts are static: the profile keeps them.
struct AskedMap {
  const char* option;
  const char* what;
  const char* meaning;
  const char* digest_meaning;
};

const AskedMap& asked_map(const std::string& table) {
  static constexpr AskedMap kMap{"--map", "the map", "the map that the run begins with; --map FILE writes it",
                                 "its digest; --map FILE writes it"};
  static constexpr AskedMap kTargets{"--targets", "the targets",
                                     "the targets that the run begins with; --targets FILE writes it",
                                     "its digest; --targets FILE writes it"};
  static constexpr AskedMap kImages{"--images", "the images",
                                    "the images that the run begins with; --images FILE writes it",
                                    "its digest; --images FILE writes it"};
  if (table == "recognise") return kTargets;
  return table == "recognise_images" ? kImages : kMap;
}

// The map that the run begins with, for the part whose keys are in `table`; null where there is none.
const KeptMap* named_map(VehicleBuilder& builder, const std::string& table) {
  Profile& profile = builder.profile();
  const std::string key = table + ".map";
  const AskedMap& asked = asked_map(table);
  const std::string option = asked.option;
  const std::string name = profile.text(key, "", asked.meaning);
  const std::string digest = profile.text(key + "_digest", "", asked.digest_meaning);
  const KeptMap* map = builder.kept_map(table);
  const std::string wanted =
      "begins with " + std::string(asked.what) + " " + name + " (digest " + digest + ")";
  if (map == nullptr) {
    if (!name.empty() || !digest.empty()) profile.fail(key, wanted + "; give it with " + option + " FILE");
    return nullptr;
  }
  if (map->digest != digest)
    profile.fail(
        key, wanted + ", and " + option + " " + map->path + " is another one (digest " + map->digest + ")");
  return map;
}

[[noreturn]] void refuse_bytes(const KeptMap& map, const std::string& why) {
  // An option is named like what is exported for it.
  const std::string kind =
      map.table == "join" ? "cloud" : (map.option == "--map" ? "surfels" : map.option.substr(2));
  throw InputError(map.option + " " + map.path + ": " + why + "; make it again with `sortie export " + kind +
                       " LOG -o FILE`",
                   3);
}

[[noreturn]] void refuse(const KeptMap& map, const mapping::CloudFileResult& result) {
  refuse_bytes(map, "byte " + std::to_string(result.byte) + ": " + result.why);
}

// `cure`: a key of the scene and its value.
[[noreturn]] void refuse_scene(const KeptMap& map, const std::string& why, const std::string& cure) {
  throw InputError(map.option + " " + map.path + ": " + why + "; cure: --set " + cure, 2);
}

template <class T>
[[noreturn]] void refuse_other(const KeptMap& map, const std::string& key, T its, T own) {
  const std::string value = format_short(static_cast<double>(its));
  refuse_scene(
      map,
      "was made with " + key + " = " + value + ", this scene has " + format_short(static_cast<double>(own)),
      key + "=" + value);
}

[[noreturn]] void refuse(const KeptMap& map, const SurfelMapResult& result,
                         const mapping::RegistrationConfig& own) {
  const SurfelMapHead& head = result.head;
  const std::string needed = std::to_string(result.needed);
  switch (result.fault) {
    case SurfelMapFault::version:
      refuse_bytes(map, "is of version " + std::to_string(head.version) +
                            " of the format, this program reads " + std::to_string(SurfelMapHead::kVersion));
    case SurfelMapFault::length:
      refuse_bytes(map,
                   "has " + std::to_string(map.bytes.size()) +
                       " bytes, which is not what its head says: it is cut off, or something is behind it");
    case SurfelMapFault::checksum:
      refuse_bytes(map, "is damaged: its check sum is another");
    case SurfelMapFault::surfel:
      refuse_bytes(map, "byte " + std::to_string(result.byte) + ": " + result.why);
    case SurfelMapFault::order:
      refuse_bytes(map, "byte " + std::to_string(result.byte) +
                            ": a cell that is there twice, or not in the order of cells");
    case SurfelMapFault::planar:
      refuse_scene(map, own.planar ? "was made by a lidar of many rows" : "was made in the plane",
                   own.planar ? "locate.planar=false" : "locate.planar=true");
    case SurfelMapFault::cell:
      refuse_other(map, "locate.cell_m", head.cell_m, own.cell_m);
    case SurfelMapFault::min_points:
      refuse_other(map, "locate.min_points", head.min_points, own.min_points);
    case SurfelMapFault::memory_points:
      refuse_other(map, "locate.memory_points", head.memory_points, own.memory_points);
    case SurfelMapFault::room:
      refuse_scene(map, "has more surfels than this scene has room for", "limits.surfels=" + needed);
    case SurfelMapFault::window:
      refuse_scene(map, "is wider than half the window of this scene's map", "locate.window_cells=" + needed);
    case SurfelMapFault::height:
      refuse_scene(map, "is higher than half the window of this scene's map",
                   "locate.window_cells_up=" + needed);
    default:
      refuse_bytes(map, "is no map of surfaces");
  }
}

}  // namespace

void load_kept_map(VehicleBuilder& builder, mapping::Locator& locator) {
  const KeptMap* map = named_map(builder, "locate");
  if (map == nullptr) return;
  if (builder.arena().refused() != 0) return;  // its memory is still being measured
  const SurfelMapResult result = locator.load(map->bytes);
  if (result.fault != SurfelMapFault::none) refuse(*map, result, locator.registration().config());
}

std::unique_ptr<mapping::TargetStore> load_kept_targets(VehicleBuilder& builder,
                                                        const mapping::TargetStoreConfig& config) {
  const KeptMap* map = named_map(builder, "recognise");
  if (map == nullptr) return nullptr;
  mapping::TargetStoreConfig exact = config;
  mapping::TargetFileResult result = mapping::read_target_head(map->bytes);
  const auto check = [&] {
    if (result.fault == mapping::TargetFileFault::none) return;
    refuse_bytes(*map, "byte " + std::to_string(result.byte) + ": " + mapping::to_string(result.fault));
  };
  check();
  exact.targets = std::max(result.head.targets, 1u);
  exact.key_frames = std::max(result.needed, 1u);
  auto store = std::make_unique<mapping::TargetStore>(exact, builder.arena());
  if (builder.arena().refused() != 0) return store;  // its memory is still being measured
  result = mapping::load_targets(map->bytes, *store);
  check();
  std::uint64_t all = ~std::uint64_t{0};
  static_cast<void>(store->run(all));
  return store;
}

std::unique_ptr<mapping::ImageStore> load_kept_images(VehicleBuilder& builder,
                                                      const mapping::ImageStoreConfig& config) {
  const KeptMap* map = named_map(builder, "recognise_images");
  if (map == nullptr) return nullptr;
  mapping::ImageFileResult result = mapping::read_image_head(map->bytes);
  const auto check = [&] {
    if (result.fault == mapping::ImageFileFault::none) return;
    refuse_bytes(*map, "byte " + std::to_string(result.byte) + ": " + mapping::to_string(result.fault));
  };
  check();
  if (result.head.images > mapping::ImageStoreConfig::kMostImages) {
    result.fault = mapping::ImageFileFault::room;
    check();
  }
  mapping::ImageStoreConfig exact = config;
  exact.images = std::max(result.head.images, 1u);
  auto store = std::make_unique<mapping::ImageStore>(exact, builder.arena());
  if (builder.arena().refused() != 0) return store;  // its memory is still being measured
  result = mapping::load_images(map->bytes, *store);
  check();
  return store;
}

KeptCloud load_kept_cloud(VehicleBuilder& builder) {
  KeptCloud kept;
  const KeptMap* map = named_map(builder, "join");
  if (map == nullptr) return kept;
  const mapping::CloudFileResult head = mapping::read_cloud_head(map->bytes);
  if (head.fault != mapping::CloudFileFault::none) refuse(*map, head);
  kept.sensor = head.sensor;
  kept.layer = std::make_unique<mapping::SightLayer>(head.config, builder.arena());
  if (builder.arena().refused() != 0) return kept;  // its memory is still being measured
  const mapping::CloudFileResult result = mapping::load_cloud(map->bytes, *kept.layer);
  if (result.fault != mapping::CloudFileFault::none) refuse(*map, result);
  return kept;
}

}  // namespace sortie::firmware
