// SPDX-License-Identifier: BSD-3-Clause
#include "planner/uav_path/carried_map.hpp"

#include <cmath>

namespace sortie::planner {
namespace {

// A voxel that is only touched from outside is not entered by rounding.
constexpr double kTouch = 1e-9;

}  // namespace

void put_known(std::span<const CellState> known, FlightMap& map) {
  if (known.empty()) return;
  const FlightMapConfig& config = map.config();
  std::size_t index = 0;
  for (std::int32_t z = 0; z < config.nz; ++z) {
    for (std::int32_t y = 0; y < config.ny; ++y) {
      for (std::int32_t x = 0; x < config.nx; ++x) {
        const CellState state = known[index++];
        if (state != CellState::unknown)
          static_cast<void>(map.set_blocked({x, y, z}, state == CellState::blocked));  // it lies inside
      }
    }
  }
}

void CarriedMap::begin(const rt::Vector3& p_known_own_m, const rt::Quaternion& q_known_own) {
  p_known_own_m_ = p_known_own_m;
  q_known_own_ = q_known_own;
  next_row_ = 0;
  begun_ = true;
}

CellState CarriedMap::state_at(std::int32_t x, std::int32_t y, std::int32_t z) const {
  const FlightMapConfig& c = to_->config();
  if (!to_->is_inside({x, y, z})) return CellState::unknown;
  return known_[(static_cast<std::size_t>(z) * static_cast<std::size_t>(c.ny) + static_cast<std::size_t>(y)) *
                    static_cast<std::size_t>(c.nx) +
                static_cast<std::size_t>(x)];
}

void CarriedMap::carry(const Voxel3& own) const {
  const FlightMapConfig& c = to_->config();
  const rt::RotationMatrix turn = rt::to_matrix(q_known_own_);
  const rt::Vector3 middle = rt::rotate(q_known_own_, to_->middle_m(own)) + p_known_own_m_;
  const double at[3] = {middle.x - c.origin_m.x, middle.y - c.origin_m.y, middle.z - c.origin_m.z};
  std::int32_t low[3], high[3], own_cell[3];
  for (int i = 0; i < 3; ++i) {
    // Half of the box, with sides along the other frame, that holds the turned voxel.
    const double half =
        0.5 * c.voxel_m *
        (std::fabs(turn.m[3 * i]) + std::fabs(turn.m[3 * i + 1]) + std::fabs(turn.m[3 * i + 2]));
    if (!(std::fabs(at[i]) < 1e6 * c.voxel_m)) return;  // far from all that is known
    low[i] = static_cast<std::int32_t>(std::floor((at[i] - half) / c.voxel_m + kTouch));
    high[i] = static_cast<std::int32_t>(std::floor((at[i] + half) / c.voxel_m - kTouch));
    own_cell[i] = static_cast<std::int32_t>(std::floor(at[i] / c.voxel_m));
  }
  for (std::int32_t z = low[2]; z <= high[2]; ++z) {
    for (std::int32_t y = low[1]; y <= high[1]; ++y) {
      for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        if (state_at(x, y, z) != CellState::blocked) continue;
        static_cast<void>(to_->set_blocked(own, true));  // it lies inside
        return;
      }
    }
  }
  if (state_at(own_cell[0], own_cell[1], own_cell[2]) == CellState::free)
    static_cast<void>(to_->set_blocked(own, false));
}

void CarriedMap::step() {
  if (!works()) return;
  const auto ny = static_cast<std::uint32_t>(to_->config().ny);
  const auto y = static_cast<std::int32_t>(next_row_ % ny);
  const auto z = static_cast<std::int32_t>(next_row_ / ny);
  for (std::int32_t x = 0; x < to_->config().nx; ++x) carry({x, y, z});
  ++next_row_;
}

void CarriedMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "carried map")
      .fixed(known_, to_)
      .by_hand(next_row_)
      .state(begun_, p_known_own_m_, q_known_own_);
  archive.bounded(next_row_, rows());
}

}  // namespace sortie::planner
