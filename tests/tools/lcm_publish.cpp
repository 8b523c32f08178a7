// SPDX-License-Identifier: BSD-3-Clause
// lcm_publish URL SECONDS: publishes one channel of every message type, for tests of tools
// that listen.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "drivers/lcm_publisher.hpp"
#include "drivers/wire.hpp"
#include "drivers/wire_parameters.hpp"
#include "drivers/wire_records.hpp"
#include "drivers/wire_requests.hpp"
#include "drivers/wire_segments.hpp"
#include "drivers/wire_ssl.hpp"
#include "drivers/wire_telemetry.hpp"
#include "drivers/wire_truth.hpp"

namespace {

using namespace sortie;
using namespace sortie::drivers;

// A robot that drives a circle of 2 m radius at 0.5 m/s.
struct Circle {
  std::int64_t stamp_ns;
  double angle;

  [[nodiscard]] rt::ImuSample imu() const {
    rt::ImuSample sample;
    sample.stamp_ns = stamp_ns;
    sample.gyr_rad_s[2] = 0.25;
    sample.acc_m_s2[1] = 0.125;
    sample.acc_m_s2[2] = 9.81;
    sample.flags = rt::kImuGyr | rt::kImuAcc;
    return sample;
  }
  [[nodiscard]] PoseMessage pose() const {
    rt::PoseEstimate estimate;
    estimate.p_world_body_m[0] = 2 * std::sin(angle);
    estimate.p_world_body_m[1] = 2 - 2 * std::cos(angle);
    estimate.q_world_body[0] = std::cos(angle / 2);
    estimate.q_world_body[3] = std::sin(angle / 2);
    estimate.v_body_m_s[0] = 0.5;
    return to_pose_message(estimate, stamp_ns / 1000);
  }
};

template <class Encode>
void send(LcmPublisher& publisher, std::string_view channel, Encode&& encode_into) {
  static_cast<void>(publisher.publish_encoded(channel, encode_into));
}

void send_telemetry(LcmPublisher& publisher, const Circle& robot, std::int64_t step) {
  const std::int64_t utime = robot.stamp_ns / 1000;
  const ExecStats tasks{utime,
                        {{"attitude", step, 0, 11, 19, 41, 200}, {"odometry", step, 0, 5, 9, 30, 100}}};
  const PoolStats pools{utime, {{"voxels", 262144, 1000 + step, 1000 + step, 0}}};
  std::vector<NamedValue> values;
  rt::for_each_scalar(robot.imu(), [&values](const char* name, int index, auto scalar) {
    const std::string suffix = index < 0 ? "" : "[" + std::to_string(index) + "]";
    values.push_back({name + suffix, static_cast<double>(scalar)});
  });
  send(publisher, kChannelStats, [&](auto out, auto& size) { return encode(tasks, out, size); });
  send(publisher, kChannelPools, [&](auto out, auto& size) { return encode(pools, out, size); });
  send(publisher, "SORTIE_FIELDS_attitude", [&](auto out, auto& size) {
    return encode(FieldsView{utime, "attitude", values}, out, size);
  });
}

// Types that are at home in logs; lcm-logplayer sends them, too.
void send_log_records(LcmPublisher& publisher, const Circle& robot, std::int64_t step) {
  LogHeader header;
  header.version = "0.1.0";
  header.scene = "hall";
  header.base_tick_ns = 1'000'000;
  const std::uint8_t bytes[] = {0, 0, 128, 63};
  const CustomView custom{"Sonar", robot.stamp_ns, step, "range_m:f32", bytes};
  rt::JobRecord tick{};
  tick.tick = static_cast<rt::Tick>(10 * step);
  tick.streams = 1;
  tick.stream[0] = {tick.tick, 10, 0};
  tick.tasks = 1;
  tick.digest[0] = 0x0123456789abcdefu;
  tick.units[0] = 1;
  const std::uint32_t durations[] = {11000};
  const JobTiming timing{10 * step, 0, robot.stamp_ns, durations};
  rt::TruthSample truth;
  truth.stamp_ns = robot.stamp_ns;
  CanFrame frame;
  frame.id = 0x181;
  frame.size = 8;
  send(publisher, kChannelHeader, [&](auto out, auto& size) { return encode(header, out, size); });
  send(publisher, kChannelTick, [&](auto out, auto& size) { return encode(tick, out, size); });
  send(publisher, kChannelTiming, [&](auto out, auto& size) { return encode(timing, out, size); });
  send(publisher, kChannelGap, [&](auto out, auto& size) {
    return encode(GapRecord{step, 0, 3, "test"}, out, size);
  });
  send(publisher, kChannelEvent, [&](auto out, auto& size) {
    return encode(EventRecord{robot.stamp_ns / 1000, 10 * step, "ladder", "core 1", 2, "test"}, out, size);
  });
  rt::ParameterChange change;
  change.stamp_ns = robot.stamp_ns;
  std::memcpy(change.name, "drive.max_speed_m_s", sizeof("drive.max_speed_m_s"));
  change.value = 0.5;
  send(publisher, kChannelChange, [&](auto out, auto& size) { return encode(change, step, out, size); });
  const SetParameter request{robot.stamp_ns / 1000, 1, 2, step, change};
  send(publisher, kChannelSet, [&](auto out, auto& size) { return encode(request, nullptr, out, size); });
  DriveRequestMessage drive;
  drive.counter = step + 1;
  drive.speed_m_s = 0.25;
  send(publisher, kChannelDrive, [&](auto out, auto& size) { return encode(drive, nullptr, out, size); });
  FlyRequestMessage fly;
  fly.counter = step + 1;
  fly.p_world_m[2] = 1.5;
  send(publisher, kChannelFly, [&](auto out, auto& size) { return encode(fly, nullptr, out, size); });
  ParametersMessage parameters;
  parameters.scene = "hall";
  parameters.parameters = {{"drive.max_speed_m_s", "m/s", 0.5, 0, 2}};
  send(publisher, kChannelParameters, [&](auto out, auto& size) { return encode(parameters, out, size); });
  AnswersMessage answers;
  answers.robot = "blue";
  answers.task = "drive";
  answers.answers = {{7, step + 1, 0}};
  answers.state = {{"speed_m_s", 0.25}};
  send(publisher, "SORTIE_ANSWERS_drive",
       [&](auto out, auto& size) { return encode(answers, nullptr, out, size); });
  rt::SslCommand rays;
  rays.stamp_ns = robot.stamp_ns;
  rays.number = static_cast<std::uint32_t>(step);
  rays.rays = 3;
  send(publisher, kChannelSslCommand, [&](auto out, auto& size) { return encode(rays, step, out, size); });
  rt::SslReturns returns;
  returns.stamp_ns = robot.stamp_ns;
  returns.number = rays.number;
  returns.rays = 3;
  send(publisher, kChannelSsl, [&](auto out, auto& size) { return encode(returns, step, out, size); });
  send(publisher, kChannelCustom, [&](auto out, auto& size) { return encode(custom, out, size); });
  send(publisher, kChannelTruth, [&](auto out, auto& size) { return encode(truth, out, size); });
  rt::ContactTruth contacts;
  contacts.stamp_ns = robot.stamp_ns;
  static_cast<void>(contacts.contacts.push_back({}));
  send(publisher, kChannelContacts, [&](auto out, auto& size) { return encode(contacts, out, size); });
  rt::SegmentList segments;
  segments.stamp_ns = robot.stamp_ns;
  segments.segments = segments.listed = 1;
  segments.segment[0].id = 7;
  send(publisher, kChannelSegments, [&](auto out, auto& size) { return encode(segments, step, out, size); });
  rt::LocatedPose located;
  located.stamp_ns = robot.stamp_ns;
  located.verdict = rt::LocatedPose::kAccepted;
  send(publisher, kChannelLocated, [&](auto out, auto& size) { return encode(located, step, out, size); });
  rt::RecognisedPlace recognised;
  recognised.stamp_ns = robot.stamp_ns;
  recognised.verdict = rt::RecognisedPlace::kRecognised;
  send(publisher, kChannelRecognised,
       [&](auto out, auto& size) { return encode(recognised, step, out, size); });
  send(publisher, kChannelCan, [&](auto out, auto& size) { return encode(frame, out, size); });
}

}  // namespace

int main(int argc, char** argv) {
  const bool with_cut = argc == 4 && std::string_view(argv[3]) == "--with-cut";
  if (argc != 3 && !with_cut) {
    std::fprintf(stderr, "usage: lcm_publish URL SECONDS [--with-cut]\n");
    return 2;
  }
  LcmPublisher publisher({argv[1], 256, 16384});
  if (!publisher.active()) {
    std::fprintf(stderr, "%s\n", publisher.problem().c_str());
    return 4;
  }
  const long steps = std::strtol(argv[2], nullptr, 10) * 100;
  auto wake = std::chrono::steady_clock::now();
  std::vector<rt::ScanPoint> points(300);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].x_m = static_cast<float>(i) * 0.01f;
  for (long step = 0; step < steps; ++step) {
    const Circle robot{step * 10'000'000, 0.0025 * static_cast<double>(step)};
    const rt::TrackSample track{robot.stamp_ns, 2 * robot.angle, 2 * robot.angle, 0};
    send(publisher, kChannelImu, [&](auto out, auto& size) { return encode(robot.imu(), step, out, size); });
    send(publisher, kChannelTrack, [&](auto out, auto& size) { return encode(track, step, out, size); });
    send(publisher, kChannelPose, [&](auto out, auto& size) { return encode(robot.pose(), out, size); });
    if (with_cut) {
      send(publisher, "CUT", [&](auto out, auto& size) {
        const Status status = encode(robot.imu(), step, out, size);
        size -= 9;
        return status;
      });
    }
    if (step % 10 == 0) {
      rt::PointScan scan;
      scan.header.stamp_ns = robot.stamp_ns;
      scan.header.points = static_cast<std::uint32_t>(points.size());
      scan.points = points.data();
      send(publisher, kChannelScan, [&](auto out, auto& size) { return encode(scan, step / 10, out, size); });
    }
    if (step % 20 == 0) {
      send_telemetry(publisher, robot, step);
      send_log_records(publisher, robot, step);
    }
    wake += std::chrono::milliseconds(10);
    std::this_thread::sleep_until(wake);
  }
  return 0;
}
