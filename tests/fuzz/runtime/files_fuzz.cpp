// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any bytes as a file that the program reads: a log, a flight ring, or one of a
// recorded data set. The first byte chooses. All that may come out is what was read, or an error of
// one line.
#include <unistd.h>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "firmware_like/log/log_file.hpp"
#include "rt/posix/flight_reader.hpp"
#include "toolchain/import/importer.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

// A folder in memory, for as long as the process lives.
class Folder {
 public:
  Folder() : path_("/dev/shm/sortie-files-fuzz-" + std::to_string(::getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string write(const std::string& name, const char* data, std::size_t size) const {
    const std::string path = path_ + "/" + name;
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(data, static_cast<std::streamsize>(size));
    return path;
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

template <class F>
void one_line_or_none(F read) {
  try {
    read();
  } catch (const std::runtime_error& error) {
    const std::string words = error.what();
    require(!words.empty() && words.find('\n') == std::string::npos);
  }
}

void import_as(const Folder& folder, const char* kind, const std::string& path) {
  one_line_or_none([&] {
    std::ostringstream notes;
    ImportOptions options;
    options.kind = kind;
    options.path = path;
    options.out = folder.path() + "/out.lcm";
    options.notes = &notes;
    const ImportReport report = import_log(options);
    require(report.bad_rows <= report.rows);
    const ReturnCounts& returns = report.returns;
    require(returns.in == returns.used + returns.no_return + returns.out_of_range + returns.not_finite +
                              returns.time_negative + returns.time_unsorted + returns.time_beyond);
    const LogFile log(options.out);  // what was imported can be read
    require(log.damage().empty());
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  if (size == 0) return 0;
  const char* const bytes = reinterpret_cast<const char*>(data) + 1;
  const std::size_t count = size - 1;
  switch (data[0] % 8) {
    case 0:
      one_line_or_none([&] {
        const LogFile log(folder.write("a.lcm", bytes, count));
        static_cast<void>(log.truth());
      });
      break;
    case 1:
      one_line_or_none([&] {
        const rt::posix::FlightReader ring(folder.write("a.ring", bytes, count));
        for (const rt::posix::FlightJob& job : ring.jobs()) require(job.group < ring.header().groups);
      });
      break;
    case 3:
      import_as(folder, "broad", folder.write("a.imu", bytes, count));
      break;
    case 4:
      import_as(folder, "rls", folder.write("a.rls", bytes, count));
      break;
    case 5: {
      // Two files of one set: the first half and the second.
      folder.write("set_imu.csv", bytes, count / 2);
      import_as(folder, "husky", folder.write("set_odom.csv", bytes + count / 2, count - count / 2));
      break;
    }
    case 6:
      import_as(folder, "carmen", folder.write("a.clf", bytes, count));
      break;
    case 7:
      import_as(folder, "swp", folder.write("a.swp", bytes, count));
      break;
    default:
      import_as(folder, "plaza", folder.write("set_DR.txt", bytes, count));
      break;
  }
  return 0;
}
