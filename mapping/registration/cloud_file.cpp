// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/cloud_file.hpp"

#include <algorithm>
#include <bit>

#include "rt/digest.hpp"

namespace sortie::mapping {
namespace {

using Fault = CloudFileFault;

constexpr std::size_t kCloudHead = rt::canonical_size<CloudFileHead>();
constexpr std::size_t kCloudRecord = rt::canonical_size<SightRecord>();
constexpr std::size_t kCloudCheck = 8;
static_assert(kCloudHead == 52 && kCloudRecord == 96);

/// A cell of version 1.
struct FirstRecord {
  SurfelRecord surfel;
  rt::Vector3 from_m;
  SORTIE_FIELDS(surfel, from_m)
};

// Where they stand in the head.
constexpr std::uint64_t kVersionByte = 8;
constexpr std::uint64_t kSensorByte = 16;
constexpr std::uint64_t kSettingsByte = 20;
constexpr std::uint64_t kCellsByte = 48;

CloudFileHead cloud_head_of(const SightLayer& layer, CloudSensor sensor) {
  const SightConfig& config = layer.config();
  return {.sensor = static_cast<std::uint32_t>(sensor),
          .cell_m = config.cell_m,
          .min_points = config.min_points,
          .most_thickness_m = config.most_thickness_m,
          .most_flatness = config.most_flatness,
          .cells = static_cast<std::uint32_t>(layer.size())};
}

std::uint64_t cloud_bytes_of(const CloudFileHead& head) {
  const std::size_t record = head.version == 1 ? rt::canonical_size<FirstRecord>() : kCloudRecord;
  return kCloudHead + std::uint64_t{record} * head.cells + kCloudCheck;
}

SightRecord read_cell(const CloudFileHead& head, rt::Archive& archive) {
  SightRecord one;
  if (head.version != 1) {
    archive.value(one);
    return one;
  }
  FirstRecord first;
  archive.value(first);
  return {first.surfel.key, first.surfel.sums, first.from_m};
}

bool knows_sensor(const CloudFileHead& head) {
  return head.sensor <= static_cast<std::uint32_t>(CloudSensor::camera);
}

/// False for what is not a number, too.
bool has_settings(const CloudFileHead& head) {
  return head.cell_m >= 0.01 && head.cell_m <= 100.0 && head.min_points >= 1 &&
         head.min_points <= kMostSurfelPoints && head.most_thickness_m > 0.0 &&
         head.most_thickness_m <= 100.0 && head.most_flatness > 0.0 && head.most_flatness <= 1.0;
}

/// Of the window that holds the cells of a box, each in a place of its own.
std::uint32_t cloud_side(const SurfelBox& box, int axis) {
  return std::bit_ceil(std::max(2u, box.cells(axis)));
}
std::uint32_t cloud_width(const SurfelBox& box) { return std::max(cloud_side(box, 0), cloud_side(box, 1)); }

bool is_wide(const SurfelBox& box) {
  return std::uint64_t{cloud_width(box)} * cloud_width(box) * cloud_side(box, 2) > kMostCloudWindow;
}

class CloudReader {
 public:
  explicit CloudReader(std::span<const std::uint8_t> bytes)
      : bytes_(bytes), archive_(rt::Archive::reading(bytes)) {}

  CloudFileResult look() {
    if (has_good_head()) look_at_records();
    return result_;
  }

  CloudFileResult load(SightLayer& layer) {
    layer.clear();
    look();
    if (result_.fault != Fault::none || !fits(layer)) return result_;
    rt::Archive records = rt::Archive::reading(bytes_.subspan(kCloudHead));
    for (std::uint32_t i = 0; i < result_.head.cells; ++i) {
      const std::uint64_t byte = kCloudHead + records.bytes();
      const SightRecord one = read_cell(result_.head, records);
      const Status status = layer.put(one);
      if (status == Status::ok) continue;
      if (status == Status::out_of_range)
        refuse(Fault::window, byte, "the cloud is wider than the layer's window");
      else
        refuse(Fault::record, byte, "a cell that the layer does not take");
      layer.clear();
      break;
    }
    return result_;
  }

 private:
  bool refuse(Fault fault, std::uint64_t byte, const char* why) {
    result_.fault = fault;
    result_.byte = byte;
    result_.why = why;
    return false;
  }

  bool has_good_head() {
    CloudFileHead& head = result_.head;
    archive_.value(head);
    if (head.magic != CloudFileHead::kMagic)
      return refuse(Fault::no_cloud, 0, "these are no bytes of a cloud");
    if (archive_.status() != Status::ok) return refuse(Fault::length, bytes_.size(), "the head is cut off");
    if (head.version < 1 || head.version > CloudFileHead::kVersion ||
        head.steps != static_cast<std::uint32_t>(kSurfelSteps))
      return refuse(Fault::version, kVersionByte, "another version of the format");
    if (head.cells > kMostCloudCells)
      return refuse(Fault::cells, kCellsByte, "more cells than a cloud may have");
    if (cloud_bytes_of(head) != bytes_.size())
      return refuse(Fault::length, bytes_.size(), "not as long as its number of cells says");
    const std::size_t body = bytes_.size() - kCloudCheck;
    rt::Archive tail = rt::Archive::reading(bytes_.subspan(body));
    std::uint64_t check = 0;
    tail.value(check);
    if (check != rt::digest_bytes(bytes_.data(), body))
      return refuse(Fault::checksum, body, "the bytes are damaged");
    if (!knows_sensor(head)) return refuse(Fault::sensor, kSensorByte, "a sensor that is not known");
    if (!has_settings(head))
      return refuse(Fault::settings, kSettingsByte, "a setting that is out of its range");
    return true;
  }

  bool look_at_records() {
    const CloudFileHead& head = result_.head;
    SurfelBox box;
    std::uint64_t last = 0;
    for (std::uint32_t i = 0; i < head.cells; ++i) {
      const std::uint64_t byte = archive_.bytes();
      const SightRecord one = read_cell(head, archive_);
      const char* const why = fault_of({one.key, one.sums, {}}, head.cell_m, false);
      if (why != nullptr) return refuse(Fault::record, byte, why);
      if (!rt::is_finite(one.from_m)) return refuse(Fault::record, byte, "a cell that was seen from nowhere");
      if (i > 0 && one.key <= last)
        return refuse(Fault::order, byte, "a cell that is there twice, or out of order");
      last = one.key;
      box.take(SurfelCell::from_key(last));
      if (is_wide(box)) return refuse(Fault::window, byte, "the cloud is wider than any window");
    }
    result_.sensor = static_cast<CloudSensor>(head.sensor);
    result_.config.cell_m = head.cell_m;
    result_.config.min_points = head.min_points;
    result_.config.most_thickness_m = head.most_thickness_m;
    result_.config.most_flatness = head.most_flatness;
    result_.config.cells = head.cells;
    result_.config.window_cells = cloud_width(box);
    result_.config.window_cells_up = cloud_side(box, 2);
    return true;
  }

  bool fits(const SightLayer& layer) {
    const SightConfig& own = layer.config();
    const SightConfig& kept = result_.config;
    if (!(own.cell_m == kept.cell_m))
      return refuse(Fault::cell, kSettingsByte, "the cells are of another size than the layer's");
    if (own.min_points != kept.min_points)
      return refuse(Fault::min_points, kSettingsByte,
                    "the layer wants another number of points of a surface");
    if (!(own.most_thickness_m == kept.most_thickness_m && own.most_flatness == kept.most_flatness))
      return refuse(Fault::flat, kSettingsByte, "other cells are flat to the layer");
    if (own.cells < kept.cells)
      return refuse(Fault::room, kCellsByte, "more cells than the layer has room for");
    return true;
  }

  std::span<const std::uint8_t> bytes_;
  rt::Archive archive_;
  CloudFileResult result_;
};

}  // namespace

std::uint64_t cloud_bytes(const SightLayer& layer) {
  return kCloudHead + std::uint64_t{kCloudRecord} * layer.size() + kCloudCheck;
}

Status write_cloud(const SightLayer& layer, CloudSensor sensor, std::span<std::uint8_t> out) {
  CloudFileHead head = cloud_head_of(layer, sensor);
  if (!knows_sensor(head) || !has_settings(head) || layer.size() > kMostCloudCells)
    return Status::out_of_range;
  const std::span<const SurfelIndex> cells = layer.by_key();
  SurfelBox box;
  for (const SurfelIndex index : cells) box.take(SurfelCell::from_key(layer.record(index).key));
  if (is_wide(box)) return Status::out_of_range;
  if (out.size() < cloud_bytes(layer)) return Status::full;
  rt::Archive archive = rt::Archive::writing(out);
  archive.value(head);
  for (const SurfelIndex index : cells) {
    SightRecord one = layer.record(index);
    archive.value(one);
  }
  std::uint64_t check = rt::digest_bytes(out.data(), static_cast<std::size_t>(archive.bytes()));
  archive.value(check);
  return archive.status();
}

CloudFileResult read_cloud_head(std::span<const std::uint8_t> bytes) { return CloudReader(bytes).look(); }

CloudFileResult load_cloud(std::span<const std::uint8_t> bytes, SightLayer& layer) {
  return CloudReader(bytes).load(layer);
}

}  // namespace sortie::mapping
