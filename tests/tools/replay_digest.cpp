// SPDX-License-Identifier: BSD-3-Clause
// Replays a log and prints its digest: the runtime without the command line, for builds by other compilers
// and for other processors (toolchain/digest-matrix). Usage:
//   sortie_replay_digest LOG [scene=NAME] [from=TIME] [keyframes=FILE] [fault=TASK@TICK] [write=FILE]
// `write` makes a file of keyframes, one a second, as `sortie index --every 1` does. Exit code 3: unusable
// input.
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <string>

#include "firmware_like/log/keyframe_state.hpp"
#include "firmware_like/log/keyframes.hpp"
#include "firmware_like/log/replay.hpp"
#include "firmware_like/robots/registry.hpp"
#include "firmware_like/scene/input_error.hpp"

using namespace sortie;
using namespace sortie::firmware;

namespace {

// Takes one "key=value"; false where the key is unknown.
bool take(const std::string& word, ReplayOptions& options, std::string& write) {
  const std::size_t equals = word.find('=');
  const std::string key = word.substr(0, equals);
  const std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
  if (key == "scene")
    options.scene = value;
  else if (key == "from")
    options.from = value;
  else if (key == "keyframes")
    options.keyframes = value;
  else if (key == "fault")
    options.fault = value;
  else if (key == "write")
    write = value;
  else
    return false;
  return true;
}

std::string digest_of(const LogFile& log, ReplayOptions& options, const std::string& write) {
  std::unique_ptr<KeyframeWriter> writer;
  rt::Tick every = 0;
  if (!write.empty()) {
    options.on_tick = [&](rt::Tick tick, Runtime& runtime, LogFeed& feed) {
      if (!writer) {
        const KeyframeHead head = keyframe_head(log, runtime);
        writer = std::make_unique<KeyframeWriter>(write, head);
        every = 1'000'000'000 / static_cast<rt::Tick>(head.base_tick_ns);
      } else if (tick % every == 0) {
        writer->add(tick, save_state(runtime, feed, tick));
      }
    };
  }
  const ReplayOutcome outcome = replay(log, own_vehicles(), options);
  if (writer) writer->finish();
  return outcome.results.digest;
}

}  // namespace

int main(int argc, char** argv) {
  ReplayOptions options;
  std::string write;
  for (int i = 2; i < argc; ++i) {
    if (!take(argv[i], options, write)) argc = 0;
  }
  if (argc < 2) {
    std::cerr << "usage: sortie_replay_digest LOG [scene=NAME] [from=TIME] [keyframes=FILE] "
                 "[fault=TASK@TICK] [write=FILE]\n";
    return 2;
  }
  try {
    const LogFile log(argv[1]);
    std::cout << digest_of(log, options, write) << "\n";
  } catch (const std::exception& error) {
    std::cerr << "sortie_replay_digest: " << error.what() << "\n";
    return 3;
  }
  return 0;
}
