// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "toolchain/report/plots.hpp"

namespace sortie::toolchain {

namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
const char* const kFlipperNames[rt::kFlippers] = {"front left", "front right", "rear left", "rear right"};

Plot over_time(const char* title, const char* unit) { return {title, {"time, s"}, {unit}, 640, 260}; }

template <class Value>
Series series_of(std::span<const firmware::ContactSummary> contacts, std::string name, int colour,
                 Value value) {
  Series s{std::move(name), Mark::line, colour};
  for (const firmware::ContactSummary& summary : contacts)
    s.add(static_cast<double>(summary.stamp_ns) * 1e-9, value(summary));
  return s;
}

}  // namespace

std::vector<Plot> plot_contacts(std::span<const firmware::ContactSummary> contacts) {
  if (contacts.empty()) return {};
  Plot counts = over_time("Contacts by part (truth)", "contacts");
  counts.y.low = 0.0;
  for (std::uint32_t part = 0; part < rt::kVehicleParts; ++part) {
    std::string name = rt::kVehiclePartNames[part];
    for (char& c : name) c = c == '_' ? ' ' : c;
    Series s = series_of(
        contacts, std::move(name), static_cast<int>(part),
        [part](const firmware::ContactSummary& c) { return static_cast<double>(c.contacts[part]); });
    s.mark = Mark::steps;
    counts.series.push_back(std::move(s));
  }
  Plot angles = over_time("Flipper angles (truth; dashed: asked for)", "degrees, tip up");
  Plot torques = over_time("Flipper torques (truth)", "N m, tip up");
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    const int colour = static_cast<int>(i);
    Series asked = series_of(contacts, "", colour, [i](const firmware::ContactSummary& c) {
      return kDegrees * c.flipper_asked_rad[i];
    });
    asked.dashed = true;
    angles.series.push_back(std::move(asked));
    angles.series.push_back(
        series_of(contacts, kFlipperNames[i], colour,
                  [i](const firmware::ContactSummary& c) { return kDegrees * c.flipper_angle_rad[i]; }));
    torques.series.push_back(
        series_of(contacts, kFlipperNames[i], colour,
                  [i](const firmware::ContactSummary& c) { return c.flipper_torque_n_m[i]; }));
  }
  return {std::move(counts), std::move(angles), std::move(torques)};
}

}  // namespace sortie::toolchain
