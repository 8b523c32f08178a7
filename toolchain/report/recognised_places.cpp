// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/report/recognised_places.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/parts/recognise_output.hpp"
#include "mapping/recognition/target_store.hpp"
#include "mapping/registration/scan_registration.hpp"

namespace sortie::toolchain {
namespace {

using rt::RecognisedPlace;

// Each surface that stands upright as a line as long as its cell.
std::vector<std::array<double, 4>> upright_surfaces(const mapping::SurfelLayer& layer) {
  constexpr double kMostUp = 0.5;  // of the normal
  std::vector<std::array<double, 4>> lines;
  for (const mapping::SurfelIndex index : layer.by_key()) {
    const mapping::SurfelRecord record = layer.record(index);
    const mapping::Surfel& surfel = record.surfel;
    const rt::Vector3 normal = surfel.normal();
    if (surfel.count < mapping::kSureSurface || !mapping::is_surface(surfel, layer.cell_m()) ||
        std::fabs(normal.z) > kMostUp)
      continue;
    const auto cell = mapping::SurfelCell::from_key(record.key & ~mapping::SurfelRecord::kOtherSide);
    const rt::Vector3 middle = layer.centre_m(cell) + surfel.mean();
    const double half = 0.5 * layer.cell_m() / std::hypot(normal.x, normal.y);
    lines.push_back({middle.x - half * normal.y, middle.y + half * normal.x, middle.x + half * normal.y,
                     middle.y - half * normal.x});
  }
  return lines;
}

}  // namespace

void RecognisedPlaces::find(const firmware::Runtime& runtime) {
  runtime_ = &runtime;
  task_ = nullptr;
  seen_ = 0;
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t g = 0; g < executive.group_count(); ++g) {
    for (const rt::TaskBase* task : executive.group(g).tasks) {
      if (dynamic_cast<const rt::Task<firmware::RecogniseOutput>*>(task) != nullptr) task_ = task;
    }
  }
}

void RecognisedPlaces::know(const firmware::Runtime& runtime) {
  const mapping::TargetStore& store = *runtime.vehicle().recognition()->known;
  for (std::size_t i = 0; i < store.records().size(); ++i) {
    if (store.records()[i].state != mapping::TargetState::kept) continue;
    known_.targets.push_back(store.places()[i]);
    known_.voxels.push_back(store.records()[i].voxels);
  }
  const mapping::ScanRegistration* map = runtime.vehicle().surfels();
  if (map != nullptr && runtime.profile().has("locate.map_digest"))
    known_.surfaces_m = upright_surfaces(map->layer(0));
}

RecognisedLook RecognisedPlaces::look(const RecognisedAnswer& answer,
                                      const firmware::Runtime& runtime) const {
  const firmware::RecognitionView view = *runtime.vehicle().recognition();
  RecognisedLook look{answer, {}, {}, map_points(runtime.vehicle())};
  std::vector<bool> is_matched(view.recogniser->segments().size());
  for (std::uint32_t i = 0; i < view.best->count; ++i) {
    look.matched.push_back(view.recogniser->pairs()[view.best->pairs[i]]);
    is_matched[look.matched.back().pair.segment] = true;
  }
  for (std::size_t i = 0; i < is_matched.size(); ++i) {
    if (!is_matched[i]) look.others.push_back(view.recogniser->segments()[i].place);
  }
  return look;
}

void RecognisedPlaces::job(const rt::JobRecord& record, const firmware::Runtime& runtime) {
  if (runtime_ != &runtime) {
    find(runtime);
    // Before a scan of this run has become part of the map.
    if (task_ != nullptr && runtime.vehicle().recognition()) know(runtime);
  }
  if (task_ == nullptr || record.group != task_->group()) return;
  const std::optional<firmware::RecognitionView> view = runtime.vehicle().recognition();
  if (!view || view->answers == seen_) return;
  seen_ = view->answers;
  const auto& output = static_cast<const rt::Task<firmware::RecogniseOutput>*>(task_)->value();
  RecognisedAnswer answer{1e-9 * static_cast<double>(output.stamp_ns - runtime.executive().time_of(0)),
                          output};
  answers_.push_back(answer);
  if (view->best->count == 0) return;
  const std::uint8_t verdict = output.verdict;
  if (verdict != RecognisedPlace::kRecognised && verdict != RecognisedPlace::kUnverified)
    refused_ = look(answer, runtime);
  else if (verdict == RecognisedPlace::kRecognised || !accepted_ ||
           accepted_->answer.place.verdict == RecognisedPlace::kUnverified)
    accepted_ = look(answer, runtime);
}

const char* verdict_words(std::uint8_t verdict) {
  switch (verdict) {
    case RecognisedPlace::kRecognised:
      return "recognised: segments agree, and the scan fits";
    case RecognisedPlace::kUnverified:
      return "unverified: segments agree, and no scan was held against the map";
    case RecognisedPlace::kFew:
      return "few segments, or few targets like them";
    case RecognisedPlace::kInconsistent:
      return "inconsistent: no set of segments agrees";
    case RecognisedPlace::kBent:
      return "bent: no pose lays what agrees";
    case RecognisedPlace::kNarrow:
      return "narrow: what agrees stands in a row";
    case RecognisedPlace::kAmbiguous:
      return "ambiguous: another place has nearly as many";
    case RecognisedPlace::kUndecided:
      return "undecided: the units were spent";
    case RecognisedPlace::kRefused:
      return "refused: segments agree, but the scan does not fit";
    default:
      return "nothing was searched";
  }
}

int verdict_colour(std::uint8_t verdict) {
  return verdict == RecognisedPlace::kRecognised   ? kGreen
         : verdict == RecognisedPlace::kUnverified ? kOrange
                                                   : kVermilion;
}

}  // namespace sortie::toolchain
