// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/sight_score.hpp"

#include <cmath>

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

constexpr double kBesides = 0.7;    ///< of a cell: how far before and behind it is looked
constexpr double kNearest_m = 0.3;  ///< what stands nearer to the sensor is not looked at
constexpr double kBefore_m = 0.6;   ///< what a line goes through ends at least so far before its cell
constexpr double kGrazing = 0.3;    ///< least cosine between a line and a normal
constexpr int kMostRaySteps = 160;

/// Whether a line of sight goes through the middle of a surface, well before its end.
bool goes_through(const SightLayer& other, const Vector3& from, const Vector3& to) {
  const double range = rt::norm(to - from);
  const double step = 0.5 * other.cell_m();
  const double end = range - kBefore_m - other.cell_m();
  if (!(end > kNearest_m)) return false;
  const Vector3 ray = (1.0 / range) * (to - from);
  const SightCell* last = nullptr;
  double at = kNearest_m;
  for (int k = 0; k < kMostRaySteps && at < end; ++k, at += step) {
    const SightCell* const cell = other.at(from + at * ray);
    if (cell == nullptr || cell == last) continue;
    last = cell;
    const double slope = dot(cell->normal, ray);
    if (std::fabs(slope) < kGrazing) continue;
    const double hit = dot(cell->normal, cell->mean_m - from) / slope;
    const Vector3 off = from + hit * ray - cell->mean_m;
    if (dot(off, off) < 0.16 * other.cell_m() * other.cell_m() && hit < range - kBefore_m) return true;
  }
  return false;
}
}  // namespace

const SightCell* surface_at(const SightLayer& other, const Vector3& mean_m, const Vector3& normal,
                            double distance_m, double least_cosine, bool& known) {
  known = false;
  for (const double besides : {0.0, -kBesides, kBesides}) {
    const SightCell* const cell = other.at(mean_m + besides * other.cell_m() * normal);
    if (cell == nullptr) continue;
    known = true;
    if (dot(cell->normal, normal) > least_cosine &&
        std::fabs(dot(cell->normal, mean_m - cell->mean_m)) < distance_m)
      return cell;
  }
  return nullptr;
}

SightCount count_sights(std::span<const SightCell> cells, const SightLayer& other,
                        const PlanePose& T_other_cells, const SightGates& gates, const SightBits& bits) {
  const rt::RotationMatrix r = rt::to_matrix(T_other_cells.q_target_source);
  const double scale = T_other_cells.scale;
  const auto there = [&](const Vector3& x) { return scale * (r * x) + T_other_cells.p_target_source_m; };
  SightCount count;
  for (std::size_t word = 0; 64 * word < cells.size(); ++word)
    bits.on[word] = bits.off[word] = bits.through[word] = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const SightCell& cell = cells[i];
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    const Vector3 mean = there(cell.mean_m);
    const double distance = gates.distance_m + 3.0 * scale * cell.sigma_m;
    bool known{};
    if (surface_at(other, mean, r * cell.normal, distance, gates.least_cosine, known) != nullptr) {
      bits.on[i / 64] |= bit;
      ++count.on;
    } else if (known) {
      bits.off[i / 64] |= bit;
      ++count.off;
    }
    if (goes_through(other, there(cell.from_m), mean)) {
      bits.through[i / 64] |= bit;
      ++count.through;
    }
  }
  return count;
}

}  // namespace sortie::mapping
