// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/commands/export_maps.hpp"

#include "firmware_like/scene/input_error.hpp"
#include "mapping/recognition/image_file.hpp"
#include "mapping/recognition/target_file.hpp"
#include "mapping/registration/cloud_file.hpp"
#include "mapping/registration/cloud_match.hpp"
#include "mapping/registration/surfel_map.hpp"
#include "toolchain/export/ply.hpp"

namespace sortie::toolchain {

using firmware::InputError;

void export_ply(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out) {
  std::vector<CloudPoint> points;
  outcome.runtime->vehicle().for_each_voxel(
      [&points](const firmware::VoxelOnMap& voxel) { points.push_back(to_cloud_point(voxel)); });
  if (points.empty())
    throw InputError(log + ": this scene keeps no map; export ply needs a scene with task map", 2);
  write_ply(out, points);
}

void export_surfels(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out) {
  const mapping::ScanRegistration* map = outcome.runtime->vehicle().surfels();
  if (map == nullptr)
    throw InputError(
        log + ": this scene makes no map of surfaces; choose one with part locate, as ugv_locate", 2);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::surfel_map_bytes(*map)));
  if (mapping::write_surfel_map(*map, bytes) != Status::ok)
    throw InputError(log + ": its map of surfaces cannot be written", 3);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void export_targets(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out) {
  const mapping::TargetStore* targets = outcome.runtime->vehicle().targets();
  if (targets == nullptr)
    throw InputError(
        log +
            ": this scene makes no targets; add --set tasks.recognise.enabled=true to one with a map of "
            "segments",
        2);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::target_file_bytes(*targets)));
  if (mapping::write_targets(*targets, bytes) != Status::ok)
    throw InputError(log + ": its targets cannot be written", 3);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void export_images(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out) {
  const mapping::ImageStore* images = outcome.runtime->vehicle().images();
  if (images == nullptr)
    throw InputError(
        log +
            ": this scene makes no height images; add --set tasks.recognise_images.enabled=true to one with "
            "a map",
        2);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::image_file_bytes(*images)));
  if (mapping::write_images(*images, bytes) != Status::ok)
    throw InputError(log + ": its height images cannot be written", 3);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void export_cloud(const firmware::ReplayOutcome& outcome, const std::string& log, std::ostream& out) {
  const mapping::SensedCloud* cloud = outcome.runtime->vehicle().cloud();
  if (cloud == nullptr)
    throw InputError(log +
                         ": this scene makes no cloud; choose one with part cloud, or add --set "
                         "tasks.cloud.enabled=true",
                     2);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::cloud_bytes(*cloud->layer)));
  if (mapping::write_cloud(*cloud->layer, cloud->sensor, bytes) != Status::ok)
    throw InputError(log + ": its cloud cannot be written", 3);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace sortie::toolchain
