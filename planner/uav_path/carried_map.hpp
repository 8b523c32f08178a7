// SPDX-License-Identifier: BSD-3-Clause
// What another robot knows of the air, carried into the map of a vehicle whose frame is another one.
#pragma once

#include <cstdint>
#include <span>

#include "planner/uav_path/flight_map.hpp"

namespace sortie::planner {

/// What is known of a voxel.
enum class CellState : std::uint8_t { unknown, free, blocked };

/// Says what is known of each voxel, x fastest, then y, then z; what is not known stays as the map has it.
/// `known`: one a voxel, or none at all. Set-up.
void put_known(std::span<const CellState> known, FlightMap& map);

/// Voxels of the own frame lie across those of the other one. A voxel is blocked where any that it may touch
/// is blocked, free where the one that holds its middle is free and none is blocked; else it stays as it was.
/// So walls get thicker by up to a voxel, and nothing that was blocked gets lost. Works in slices; no heap.
class CarriedMap {
 public:
  /// `known`: states of the voxels of a map of the size and corner of `to`, in the other frame. Both outlive
  /// it.
  CarriedMap(std::span<const CellState> known, FlightMap& to) : known_(known), to_(&to) {}

  /// The own frame lies in the other one so: x_known = R(q) x_own + p. Starts anew.
  void begin(const rt::Vector3& p_known_own_m, const rt::Quaternion& q_known_own);
  bool has_begun() const { return begun_; }
  bool works() const { return begun_ && next_row_ < rows(); }
  /// A row of voxels along x: 50 ns each at the most.
  void step();

  /// State to bytes and back; the map is archived by its owner.
  void archive(rt::Archive& archive);

 private:
  std::uint32_t rows() const {
    return static_cast<std::uint32_t>(to_->config().ny) * static_cast<std::uint32_t>(to_->config().nz);
  }
  CellState state_at(std::int32_t x, std::int32_t y, std::int32_t z) const;
  void carry(const Voxel3& own) const;

  std::span<const CellState> known_;
  FlightMap* to_;
  bool begun_{};
  rt::Vector3 p_known_own_m_;
  rt::Quaternion q_known_own_;
  std::uint32_t next_row_{};
};

}  // namespace sortie::planner
