// SPDX-License-Identifier: BSD-3-Clause
// Exported files read back: by our own readers, by a JSON parser, and by the tools themselves where
// installed.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>
#include <sstream>

#include "drivers/candump.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/json.hpp"
#include "rt/samples.hpp"
#include "tests/firmware_like/temp_folder.hpp"
#include "tests/toolchain/tum_reader.hpp"
#include "toolchain/export/candump.hpp"
#include "toolchain/export/chrome_trace.hpp"
#include "toolchain/export/csv.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/export/ply.hpp"
#include "toolchain/export/tum.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using sortie::testing::read_all;
using sortie::testing::read_tum;
using sortie::testing::TempFolder;

TEST_CASE("a trajectory survives TUM bit for bit") {
  std::mt19937_64 random(4);
  Trajectory t;
  for (int i = 0; i < 500; ++i) {
    TimedPose p;
    p.stamp_ns = 1'600'000'000'000'000'000 + static_cast<std::int64_t>(random() % 1'000'000'000'000);
    for (double& x : p.p) x = (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5) * 1e4;
    for (double& x : p.q) x = static_cast<double>(random() >> 11) * 0x1p-53;
    t.push_back(p);
  }
  const TempFolder folder;
  write_file(folder.file("t.txt"), [&](std::ostream& out) { CHECK(write_tum(out, t) == 500); });
  const Trajectory back = read_tum(folder.file("t.txt"));
  REQUIRE(back.size() == t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    CHECK(back[i].stamp_ns == t[i].stamp_ns);
    CHECK(std::equal(t[i].p, t[i].p + 3, back[i].p));
    CHECK(std::equal(t[i].q, t[i].q + 4, back[i].q));
  }
  std::ostringstream line;
  TimedPose p;
  p.stamp_ns = 1'432'235'498'027'976'000;
  p.p[0] = 1.5;
  write_tum(line, std::vector<TimedPose>{p});
  CHECK(line.str() == "1432235498.027976000 1.5 0 0 0 0 0 1\n");
}

TEST_CASE("a cloud is written as PLY with its segments' colours, points that are no points left out") {
  std::vector<CloudPoint> points{
      {1.5f, -2.25f, 0.1f, 7}, {std::nanf(""), 0, 0, 1}, {1e-7f, 3e8f, -0.0f, 4294967295u, 3}};
  points[2].red = 255;
  const std::string head_text =
      "1.0\ncomment metres, world frame\nelement vertex 2\nproperty float x\nproperty float y\nproperty "
      "float "
      "z\nproperty uint hits\nproperty uint segment\nproperty uchar red\nproperty uchar green\nproperty "
      "uchar "
      "blue\n";
  std::ostringstream binary;
  CHECK(write_ply(binary, points) == 2);
  const std::string bytes = binary.str();
  const std::size_t head = bytes.find("end_header\n") + 11;
  CHECK(bytes.substr(0, head) == "ply\nformat binary_little_endian " + head_text + "end_header\n");
  REQUIRE(bytes.size() == head + 46);
  float z = 0.0f;
  std::uint32_t hits = 0;
  std::memcpy(&z, bytes.data() + head + 8, 4);
  std::memcpy(&hits, bytes.data() + head + 35, 4);
  CHECK(z == 0.1f);
  CHECK(hits == 4294967295u);
  CHECK(bytes[head + 39] == 3);
  CHECK(static_cast<unsigned char>(bytes[head + 43]) == 255);
  // One normal, and all points have room for one.
  points[2].normal[2] = 1.0f;
  std::ostringstream with_normals;
  CHECK(write_ply(with_normals, points) == 2);
  CHECK(with_normals.str().find(
            "blue\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n") !=
        std::string::npos);
  CHECK(with_normals.str().size() - with_normals.str().find("end_header\n") - 11 == 70);
}

TEST_CASE("voxels of one segment are of one colour, of none grey, and of the next segment another colour") {
  VoxelOnMap voxel;
  CHECK(to_cloud_point(voxel).red == 128);
  CHECK(to_cloud_point(voxel).blue == 128);
  const auto colour = [&voxel](std::uint32_t segment) {
    voxel.segment = segment;
    const CloudPoint p = to_cloud_point(voxel);
    return std::array<int, 3>{p.red, p.green, p.blue};
  };
  for (std::uint32_t id = 1; id < 1000; ++id) {
    const std::array<int, 3> a = colour(id);
    const std::array<int, 3> b = colour(id + 1);
    CHECK(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 200);
    CHECK(colour(id) == a);
  }
}

TEST_CASE("a series becomes CSV with time first, under the names of a described struct") {
  std::ostringstream out;
  const auto columns = csv_columns<rt::TrackSample>();
  CHECK(columns == std::vector<std::string>{"stamp_ns", "left_m", "right_m", "flags"});
  CHECK(csv_columns<rt::ImuSample>()[1] == "gyr_rad_s_0");
  CsvWriter csv(out, columns);
  csv.row(1'500'000'000, {9'007'199'254'740'992, 0.1, std::nan(""), 3});
  csv.row(2'000'000'000, std::vector<double>{1, 2, 3, 4});
  CHECK(out.str() ==
        "time,stamp_ns,left_m,right_m,flags\n1.500000000,9007199254740992,0.1,,3\n2.000000000,1,2,3,4\n");
  CHECK_THROWS_AS(csv.row(0, std::vector<double>{1}), std::invalid_argument);
  std::ostringstream names;
  CsvWriter(names, {"a:b", "c,d\"e"});
  CHECK(names.str() == "time,a_b,c_d_e\n");
}

TEST_CASE("frames are written as candump reads them") {
  const std::vector<drivers::CanFrame> frames{
      {1'700'000'000'123'456'000, 0x101, 2, 0, {0x00, 0xff}},
      {1'700'000'001'000'000'000, 0x0DF805A0, 8, drivers::kCanExtended, {1, 2, 3, 4, 5, 6, 7, 8}},
      {-5, 0x101, 0, 0, {}}};
  const TempFolder folder;
  CandumpCounts counts;
  write_file(folder.file("a.log"), [&](std::ostream& out) { counts = write_candump(out, frames); });
  CHECK(counts.frames == 2);
  CHECK(counts.refused == 1);
  CHECK(read_all(folder.file("a.log")) ==
        "(1700000000.123456) can0 101#00FF\n(1700000001.000000) can0 0DF805A0#0102030405060708\n");
  drivers::CandumpReader reader(folder.file("a.log"));
  drivers::CandumpRecord record;
  REQUIRE(reader.next(record) == Status::ok);
  REQUIRE(reader.next(record) == Status::ok);
  CHECK(record.frame.id == 0x0DF805A0);
  CHECK(record.frame.data[7] == 8);
  if (std::system("command -v log2asc >/dev/null 2>&1") != 0) {
    WARN("skipped: log2asc (can-utils) is not installed");
    return;
  }
  const std::string command = "log2asc -I " + folder.file("a.log") + " -O " + folder.file("a.asc") + " can0";
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(read_all(folder.file("a.asc")).find("DF805A0x") != std::string::npos);
}

TEST_CASE("a trace is JSON whose spans nest on every track") {
  std::mt19937 random(8);
  Trace trace;
  trace.tracks = {{0, "imu \"fast\""}, {1, "map\\\n"}};
  for (int i = 0; i < 2000; ++i) {
    TraceSpan span;
    span.name = i % 7 == 0 ? "job\xff" : "task";  // not UTF-8: must not break the file
    span.track = static_cast<int>(random() % 2);
    span.start_ns = 1'000'000'000 + static_cast<std::int64_t>(random() % 1'000'000);
    span.duration_ns = static_cast<std::int64_t>(random() % 5'000);
    if (i % 3 == 0) span.details = {{"tick", std::to_string(i)}};
    trace.spans.push_back(span);
  }
  trace.spans[5].duration_ns = -3;
  std::ostringstream out;
  const std::size_t cuts = write_chrome_trace(out, trace, 1'000'000'000);
  CHECK(cuts > 0);
  const auto json = Json::parse(out.str());
  std::map<int, std::vector<double>> open;
  std::map<int, double> latest;
  std::size_t spans = 0;
  for (const auto& event : json["traceEvents"]) {
    const auto kind = event["ph"].get<std::string>();
    if (kind != "X") continue;
    ++spans;
    const auto track = event["tid"].get<int>();
    const auto start = event["ts"].get<double>();
    const double end = start + event["dur"].get<double>();
    REQUIRE(event["dur"].get<double>() >= 0.0);
    REQUIRE(start >= latest[track]);
    latest[track] = start;
    auto& stack = open[track];
    while (!stack.empty() && stack.back() <= start + 1e-6) stack.pop_back();
    if (!stack.empty()) REQUIRE(end <= stack.back() + 1e-6);
    stack.push_back(end);
  }
  CHECK(spans == 2000);
  CHECK(json["traceEvents"][1]["args"]["name"] == "imu \"fast\"");
}

TEST_CASE("spans that already nest are written as they are, to the nanosecond") {
  Trace trace;
  trace.spans = {
      {"job", 0, 1'234'567, 1'000, {}}, {"task", 0, 1'234'600, 967, {}}, {"next", 0, 1'235'567, 5, {}}};
  std::ostringstream out;
  CHECK(write_chrome_trace(out, trace) == 0);
  CHECK(out.str().find(R"("ts":1234.567,"dur":1.000)") != std::string::npos);
  CHECK(out.str().find(R"("ts":1234.600,"dur":0.967)") != std::string::npos);
}

TEST_CASE("a file is either whole or not there") {
  const TempFolder folder;
  folder.write("a", "old");
  CHECK_THROWS_AS(write_file(folder.file("a"),
                             [](std::ostream& out) {
                               out << "new";
                               throw std::runtime_error("half way");
                             }),
                  std::runtime_error);
  CHECK(read_all(folder.file("a")) == "old");
  CHECK_FALSE(std::filesystem::exists(folder.file("a.part")));
  write_file(folder.file("a"), [](std::ostream& out) { out << "new"; });
  CHECK(read_all(folder.file("a")) == "new");
  try {
    write_file(folder.file("no/folder/a"), [](std::ostream&) {});
    FAIL("a folder that is not there was accepted");
  } catch (const InputError& error) {
    CHECK(std::string(error.what()).find("No such file") != std::string::npos);
    CHECK(error.exit_code() == 3);
  }
  write_file("/dev/null", [](std::ostream& out) { out << "gone"; });
  CHECK(std::filesystem::exists("/dev/null"));
  CHECK_FALSE(std::filesystem::is_regular_file("/dev/null"));
  if (std::filesystem::exists("/dev/full")) {
    const auto fill = [](std::ostream& out) { out << std::string(1 << 20, 'x'); };
    CHECK_THROWS_AS(write_file("/dev/full", fill), InputError);
  }
}
