// SPDX-License-Identifier: BSD-3-Clause
// The frame table in docs/formats.md is the one in the code.
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include "drivers/can_frames.hpp"

using namespace sortie::drivers;

namespace {

std::string frame_table() {
  std::string table =
      "| id | frame | bytes | field | type | step | meaning |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const CanMessage& frame : kCanFrames) {
    for (std::size_t i = 0; i < frame.field_count; ++i) {
      const CanSignal& field = frame.fields[i];
      char id[8];
      char step[32];
      std::snprintf(id, sizeof id, "0x%03X", static_cast<unsigned>(frame.id));
      std::snprintf(step, sizeof step, "%g %s", field.scale, field.unit);
      const int first = field.shift / 8;
      const int last = (field.shift + field.length - 1) / 8;
      const std::string bytes =
          std::to_string(first) + (last > first ? ".." + std::to_string(last) : std::string());
      table += "| " + (i == 0 ? std::string(id) : "") + " | " +
               (i == 0 ? std::string("`") + frame.name + "` (" + frame.meaning + ")" : "") + " | " + bytes +
               " | " + field.name + " | " + (field.value == CanValue::signed_whole ? "int" : "uint") +
               std::to_string(field.length) + " | " + (field.unit[0] == '\0' ? "" : step) + " | " +
               field.meaning + " |\n";
    }
  }
  return table;
}

}  // namespace

TEST_CASE("the frame table in docs/formats.md is the one in the code") {
  const std::string path = std::string(SORTIE_SOURCE_DIR) + "/docs/formats.md";
  std::ifstream file(path);
  if (!file) {
    WARN("skipped: " << path << " is not there");
    return;
  }
  std::ostringstream text;
  text << file.rdbuf();
  INFO("the table of the code:\n" << frame_table());
  CHECK(text.str().find(frame_table()) != std::string::npos);
}
