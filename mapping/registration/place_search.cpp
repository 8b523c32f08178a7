// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_search.hpp"

#include <algorithm>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kSearchPi = 3.14159265358979323846;
constexpr std::int32_t kFarthestPlace = 1 << 24;  ///< whole steps: no map is so wide
constexpr double kFarVoxels = 8000.0;             ///< a return stays within, and in 16 bits
constexpr std::uint32_t kScanned = 16;            ///< bounds that are read in the time of a unit
}  // namespace

PlaceSearch::PlaceSearch(const PlaceSearchConfig& config, const PlaceMap& map, rt::Arena& arena)
    : config_(config),
      map_(&map),
      bounds_(arena.make_array<std::uint8_t>(
          "place_bounds", std::size_t{config.tops} * PlaceTiles::kLanes * static_cast<std::size_t>(kTurns))),
      offsets_(arena.make_array<PlaceOffset>(
          "place_offsets", static_cast<std::size_t>(kTurns) * PlaceSearchConfig::kMostReturns)),
      narrowed_(arena.make_array<std::uint8_t>("place_narrowed",
                                               std::size_t{config.tops} * static_cast<std::size_t>(kTurns))),
      looks_(arena.make_array<PlaceTiles::Look>("place_looks", PlaceSearchConfig::kMostReturns)),
      part_looks_(arena.make_array<PlaceTiles::Look>("place_looks", PlaceSearchConfig::kMostReturns)) {}

double PlaceSearch::turn_rad(std::int32_t turn) { return turn * (2.0 * kSearchPi / kTurns); }

bool PlaceSearch::near(const PlaceCell& a, const PlaceCell& b) {
  for (int i = 0; i < 3; ++i) {
    const std::int32_t apart = a.at[i] - b.at[i];
    if (apart > kNearSteps || apart < -kNearSteps) return false;
  }
  const std::int32_t turned = (a.turn - b.turn) & (kTurns - 1);
  return std::min(turned, kTurns - turned) <= kNearTurns;
}

PlaceCell PlaceSearch::cell(std::int32_t turn, std::uint32_t node, int lane) const {
  const auto top = static_cast<std::int32_t>(node / PlaceTiles::kLanes);
  const auto in_top = static_cast<int>(node % PlaceTiles::kLanes);
  const std::int32_t tops[3] = {top % map_->tops(0), top / map_->tops(0) % map_->tops(1),
                                top / (map_->tops(0) * map_->tops(1))};
  constexpr std::int32_t kNode = PlaceMap::kNode;
  constexpr std::int32_t kPoses = kNode * PlaceMap::kTop;
  return {{kPoses * tops[0] + kNode * PlaceTiles::lane_x(in_top) + PlaceTiles::lane_x(lane),
           kPoses * tops[1] + kNode * PlaceTiles::lane_y(in_top) + PlaceTiles::lane_y(lane),
           kPoses * tops[2] + kNode * PlaceTiles::lane_z(in_top) + PlaceTiles::lane_z(lane)},
          turn};
}

void PlaceSearch::begin(std::span<const rt::Vector3> returns_m) {
  return_count_ =
      static_cast<std::uint32_t>(std::min<std::size_t>(returns_m.size(), PlaceSearchConfig::kMostReturns));
  std::copy_n(returns_m.begin(), return_count_, returns_m_);
  step_ = return_count_ == 0 || map_->empty() ? Step::done : Step::bounds;
  turn_ = 0;
  at_ = level_ = rest_ = found_count_ = candidate_count_ = 0;
  paid_ = false;
  std::fill(std::begin(most_), std::end(most_), std::uint8_t{0});
  std::fill_n(narrowed_.begin(), static_cast<std::size_t>(kTurns * map_->tops()), std::uint8_t{0});
  credit_.clear();
  counts_ = {};
  if (step_ != Step::done) turn_returns();
}

/// Whole voxels of all returns for all turns.
void PlaceSearch::turn_returns() {
  looks_turn_ = -1;
  const double per_voxel = 1.0 / map_->voxel_m();
  const auto voxel = [&](double along_m) {
    const double at = std::clamp(along_m * per_voxel, -kFarVoxels, kFarVoxels);
    return static_cast<std::int16_t>(rt::floor(at + 0.5));
  };
  for (std::int32_t turn = 0; turn < kTurns; ++turn) {
    const double c = rt::cos(turn_rad(turn));
    const double s = rt::sin(turn_rad(turn));
    PlaceOffset* const out = &offsets_[static_cast<std::size_t>(turn) * PlaceSearchConfig::kMostReturns];
    for (std::uint32_t i = 0; i < return_count_; ++i) {
      const rt::Vector3& v = returns_m_[i];
      out[i] = {{voxel(c * v.x - s * v.y), voxel(s * v.x + c * v.y), voxel(v.z)}};
    }
  }
}

/// Of the nodes while their bounds are made, else of poses and parts.
void PlaceSearch::take_turn() {
  if (looks_turn_ == turn_) return;
  looks_turn_ = turn_;
  const PlaceOffset* const offsets =
      &offsets_[static_cast<std::size_t>(turn_) * PlaceSearchConfig::kMostReturns];
  const PlaceTiles& tiles = step_ == Step::bounds ? map_->nodes() : map_->poses();
  for (std::uint32_t i = 0; i < return_count_; ++i) {
    looks_[i] = tiles.look(offsets[i]);
    part_looks_[i] = map_->parts().look(offsets[i]);
  }
}

bool PlaceSearch::pay(std::uint64_t cost, std::uint64_t& units) {
  if (!credit_.pay(cost, units)) return false;
  counts_.units += cost;
  return true;
}

bool PlaceSearch::run(std::uint64_t& units) {
  if (step_ == Step::bounds && run_bounds(units)) {
    step_ = Step::picks;
    looks_turn_ = -1;
    turn_ = kTurns;  // no turn is at hand
  }
  if (step_ == Step::picks && run_picks(units)) {
    step_ = Step::rivals;
    candidate_count_ = found_count_;
    turn_ = kTurns;
    paid_ = false;  // a turn that was left begins anew: what was not taken of it may be a rival
  }
  if (step_ == Step::rivals && run_picks(units)) step_ = Step::done;
  return step_ == Step::done;
}

bool PlaceSearch::run_bounds(std::uint64_t& units) {
  const auto tops = static_cast<std::uint32_t>(map_->tops());
  std::uint8_t counts[PlaceTiles::kLanes];
  for (; turn_ < kTurns; ++turn_, at_ = 0) {
    for (; at_ < tops; ++at_) {
      if (!pay(2 * return_count_, units)) return false;
      take_turn();
      ++counts_.tops;
      const auto top = static_cast<std::int32_t>(at_);
      const std::int32_t block[3] = {top % map_->tops(0), top / map_->tops(0) % map_->tops(1),
                                     top / (map_->tops(0) * map_->tops(1))};
      map_->nodes().count({looks_.data(), return_count_}, block, counts);
      std::copy_n(counts, PlaceTiles::kLanes,
                  bounds_of(turn_).begin() + static_cast<std::ptrdiff_t>(at_) * PlaceTiles::kLanes);
      for (const std::uint8_t count : counts) most_[turn_] = std::max(most_[turn_], count);
    }
  }
  return true;
}

std::uint32_t PlaceSearch::least_hits(bool rival) const {
  const double within = rival ? config_.rivals_within : config_.within;
  const double of_all = config_.least_hits * 2.0 * return_count_;
  const double of_best = found_count_ == 0 ? 0.0 : (1.0 - within) * found_[0].hits;
  return std::max(1u, static_cast<std::uint32_t>(std::max(of_all, of_best)));
}

bool PlaceSearch::is_rivals_turn(std::int32_t turn) const {
  if (found_count_ == 0) return false;
  const std::int32_t of_quarter = (turn - found_[0].cell.turn + 1) & (kTurns / 4 - 1);
  return of_quarter <= 2;
}

std::uint32_t PlaceSearch::most_found() const {
  return step_ == Step::rivals ? candidate_count_ + config_.rivals : config_.candidates;
}

/// Opens all nodes with the most hits, turn by turn, then those with the next fewer.
bool PlaceSearch::run_picks(std::uint64_t& units) {
  const bool rivals = step_ == Step::rivals;
  const auto wanted = [&](std::int32_t turn) { return !rivals || is_rivals_turn(turn); };
  for (;;) {
    if (found_count_ == most_found()) return true;
    if (turn_ == kTurns) {
      level_ = 0;
      for (std::int32_t turn = 0; turn < kTurns; ++turn) {
        if (wanted(turn)) level_ = std::max<std::uint32_t>(level_, most_[turn]);
      }
      if (level_ < least_hits(rivals)) return true;
      turn_ = 0;
    }
    for (; turn_ < kTurns; ++turn_) {
      if (wanted(turn_) && most_[turn_] == level_ && !pick_in_turn(units)) return false;
      if (found_count_ == most_found()) return true;
    }
  }
}

bool PlaceSearch::pick_in_turn(std::uint64_t& units) {
  const std::span<std::uint8_t> bounds = bounds_of(turn_);
  if (!paid_) {
    if (!pay(nodes() / kScanned + return_count_ / 4, units)) return false;
    paid_ = true;
    at_ = rest_ = 0;
  }
  for (; at_ < nodes(); ++at_) {
    if (bounds[at_] == level_) {
      take_turn();
      if (!narrow(at_, units)) return false;
    }
    if (bounds[at_] == level_) {
      if (!pay(2 * return_count_, units)) return false;
      open(at_);
      if (found_count_ == most_found()) return true;
    }
    rest_ = std::max<std::uint32_t>(rest_, bounds[at_]);
  }
  most_[turn_] = static_cast<std::uint8_t>(rest_);
  paid_ = false;
  return true;
}

bool PlaceSearch::is_taken(const PlaceCell& cell) const {
  for (const PlaceCandidate& one : found()) {
    if (near(one.cell, cell)) return true;
  }
  return false;
}

/// Closer bounds for a node and the seven beside it, by their parts, if they have none yet.
bool PlaceSearch::narrow(std::uint32_t node, std::uint64_t& units) {
  const PlaceCell first = cell(turn_, node, 0);
  constexpr std::int32_t kEight = 2 * PlaceMap::kNode;
  const std::int32_t block[3] = {first.at[0] / kEight, first.at[1] / kEight, first.at[2] / kEight};
  const auto bit =
      static_cast<std::uint8_t>(1 << ((block[0] & 1) | (block[1] & 1) << 1 | (block[2] & 1) << 2));
  const std::uint32_t top = node / PlaceTiles::kLanes;
  std::uint8_t& narrowed = narrowed_[static_cast<std::size_t>(turn_ * map_->tops()) + top];
  if ((narrowed & bit) != 0) return true;
  if (!pay(2 * return_count_, units)) return false;
  narrowed = static_cast<std::uint8_t>(narrowed | bit);
  ++counts_.parts;
  std::uint8_t counts[PlaceTiles::kLanes];
  map_->parts().count({part_looks_.data(), return_count_}, block, counts);
  const std::span<std::uint8_t> bounds = bounds_of(turn_).subspan(std::size_t{top} * PlaceTiles::kLanes);
  std::uint8_t most[8]{};
  for (int lane = 0; lane < PlaceTiles::kLanes; ++lane) {
    const int of =
        PlaceTiles::lane_x(lane) / 2 + PlaceTiles::lane_y(lane) / 2 * 2 + PlaceTiles::lane_z(lane) / 2 * 4;
    most[of] = std::max(most[of], counts[lane]);
  }
  for (int lane = 0; lane < PlaceTiles::kLanes; ++lane) {
    const std::int32_t x = PlaceTiles::lane_x(lane), y = PlaceTiles::lane_y(lane),
                       z = PlaceTiles::lane_z(lane);
    if (x / 2 != (block[0] & 1) || y / 2 != (block[1] & 1) || z / 2 != (block[2] & 1)) continue;
    std::uint8_t& bound = bounds[static_cast<std::size_t>(lane)];
    bound = std::min(bound, most[(x & 1) + (y & 1) * 2 + (z & 1) * 4]);
  }
  return true;
}

/// Takes the node's poses that have as many hits as its bound says and are no place that was found already.
/// The most hits of the others are its bound from then on.
void PlaceSearch::open(std::uint32_t node) {
  ++counts_.nodes;
  const PlaceCell first = cell(turn_, node, 0);
  const std::int32_t block[3] = {first.at[0] / PlaceMap::kNode, first.at[1] / PlaceMap::kNode,
                                 first.at[2] / PlaceMap::kNode};
  std::uint8_t counts[PlaceTiles::kLanes];
  map_->poses().count({looks_.data(), return_count_}, block, counts);
  std::uint8_t& bound = bounds_of(turn_)[node];
  for (int i = 0; i < PlaceTiles::kLanes && found_count_ < most_found(); ++i) {
    const auto best = std::max_element(std::begin(counts), std::end(counts));
    bound = *best;
    if (*best < least_hits(step_ == Step::rivals)) return;
    const PlaceCell at = cell(turn_, node, static_cast<int>(best - std::begin(counts)));
    if (!is_taken(at)) {
      if (*best < level_) return;
      found_[found_count_++] = {at, *best};
    }
    *best = 0;
  }
  bound = *std::max_element(std::begin(counts), std::end(counts));
}

void PlaceSearch::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "place search")
      .fixed(config_, map_)
      .scratch(offsets_, looks_, part_looks_, looks_turn_)
      .by_hand(bounds_, narrowed_)
      .state(step_, returns_m_, return_count_, turn_, at_, level_, rest_, paid_, most_, found_, found_count_,
             candidate_count_, credit_, counts_);
  if (archive.is_reading()) {
    bool fits = step_ <= Step::rivals && return_count_ <= PlaceSearchConfig::kMostReturns && turn_ >= 0 &&
                turn_ <= kTurns && (step_ != Step::bounds || turn_ < kTurns) && at_ <= nodes() &&
                level_ <= 255 && rest_ <= 255 && candidate_count_ <= config_.candidates &&
                found_count_ <= config_.candidates + config_.rivals &&
                (step_ == Step::done || !map_->empty());
    for (const rt::Vector3& v : returns_m_) fits = fits && rt::is_finite(v);
    for (const PlaceCandidate& one : found_) {
      fits = fits && one.cell.turn >= 0 && one.cell.turn < kTurns;
      for (const std::int32_t at : one.cell.at) fits = fits && at > -kFarthestPlace && at < kFarthestPlace;
    }
    if (!fits) {
      archive.fail(Status::malformed, "a search that cannot be");
      step_ = Step::done;
      return_count_ = found_count_ = 0;
      return;
    }
  }
  if (step_ == Step::done) return;
  for (std::uint8_t& bound : bounds_.first(static_cast<std::size_t>(kTurns) * nodes())) archive.value(bound);
  for (std::uint8_t& narrowed : narrowed_.first(static_cast<std::size_t>(kTurns * map_->tops())))
    archive.value(narrowed);
  if (archive.is_reading()) turn_returns();
}

}  // namespace sortie::mapping
