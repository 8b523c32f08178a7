// SPDX-License-Identifier: BSD-3-Clause
// A simulated vehicle and a computer on one CAN bus, and a sink that folds scans into a digest.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "drivers/can_stub.hpp"
#include "hil/ugv_plant.hpp"
#include "rt/digest.hpp"
#include "tests/hil/units.hpp"

namespace sortie::hil {

/// Folds scans into a chain of digests and keeps none.
class DigestSink final : public drivers::ScanSink {
 public:
  rt::ScanPoint* reserve(std::uint32_t capacity) noexcept override {
    return capacity <= points_.size() ? points_.data() : nullptr;
  }
  Status commit(const rt::ScanHeader& header) noexcept override {
    std::uint64_t digest = rt::digest_of(header);
    for (std::uint32_t i = 0; i < header.points; ++i) digest = rt::digest_of(points_[i], digest);
    chain = rt::chain_digest(chain, ++scans, digest);
    points += header.points;
    return Status::ok;
  }
  void cancel() noexcept override {}
  std::uint64_t chain{};
  std::uint64_t scans{};
  std::uint64_t points{};

 private:
  std::vector<rt::ScanPoint> points_ = std::vector<rt::ScanPoint>(5760);
};

/// A vehicle and a computer on one bus, in steps of 1 ms.
struct UgvBench {
  explicit UgvBench(const UgvConfig& config, drivers::ScanSink* scans = nullptr)
      : vehicle(&bus.attach("vehicle")),
        computer(&bus.attach("computer")),
        plant(std::make_unique<UgvPlant>(config, *vehicle, scans)),
        decoder(config.can) {}

  void command(double left, double right) {
    rt::DriveCommand c;
    c.stamp_ns = now;
    c.left_m_s = left;
    c.right_m_s = right;
    c.flags = 1;
    drivers::CanFrame frame;
    REQUIRE(drivers::encode_drive(c, ++counter, frame) == Status::ok);
    REQUIRE(computer->send(frame) == Status::ok);
  }

  /// One step; returns the frames that the computer heard through `hear`.
  template <class Hear>
  void step(Hear&& hear) {
    now += kMs;
    bus.advance(now);
    drivers::CanFrame frame;
    while (computer->receive(frame) == Status::ok) hear(frame);
    REQUIRE(plant->step(now) == Status::ok);
  }

  /// Decodes everything while `drive(ms)` is called every 20 ms.
  template <class Drive>
  void run(int ms, Drive&& drive) {
    for (int i = 0; i < ms; ++i) {
      if (i % 20 == 0) drive(i);
      step([this](const drivers::CanFrame& frame) {
        drivers::CanSample sample;
        const Status status = decoder.decode(frame, sample);
        if (status != Status::ok) return;
        if (sample.kind == drivers::CanSampleKind::imu) imu.push_back(sample.imu);
        if (sample.kind == drivers::CanSampleKind::track) track.push_back(sample.track);
        if (sample.kind == drivers::CanSampleKind::flipper) flippers.push_back(sample.flipper);
      });
      truth.push_back(plant->motion());
    }
  }

  drivers::CanStub bus;
  drivers::CanBus* vehicle;
  drivers::CanBus* computer;
  std::unique_ptr<UgvPlant> plant;
  drivers::CanSampleDecoder decoder;
  rt::Nanoseconds now{};
  std::uint8_t counter{};
  std::vector<rt::ImuSample> imu;
  std::vector<rt::TrackSample> track;
  std::vector<rt::FlipperSample> flippers;
  std::vector<Motion> truth;
};

}  // namespace sortie::hil
