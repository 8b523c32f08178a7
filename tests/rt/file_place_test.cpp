// SPDX-License-Identifier: BSD-3-Clause
// A file in the making: what stands at its place stays until it is taken, and what a killed maker left is in
// nobody's way.
#include "rt/posix/file_place.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>

#include "tests/rt/flight_ring_rig.hpp"

namespace sortie::rt::posix {

using namespace test;

namespace {

void put(const FilePlace& place, const std::string& text) {
  REQUIRE(write(place.descriptor(), text.data(), text.size()) == static_cast<ssize_t>(text.size()));
}

std::string refusal(const std::string& path) {
  try {
    const FilePlace place(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("what stands at a place stays until the new file takes it, and is kept or replaced as told") {
  const RingFolder folder;
  const std::string path = folder.file("log");
  write_bytes(path, "first");
  {
    const FilePlace place(path);
    put(place, "refused");
    CHECK(place.occupied());
    CHECK(bytes_of(path) == "first");
  }
  CHECK(bytes_of(path) == "first");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  for (const char* text : {"second", "third"}) {
    const std::string before = bytes_of(path);
    FilePlace place(path);
    put(place, text);
    CHECK(place.take(FormerFile::kept).empty());
    CHECK(place.taken());
    CHECK(place.former_kept());
    CHECK(bytes_of(path) == text);
    CHECK(bytes_of(path + ".previous") == before);
    put(place, "+");  // it is the same file under its new name
    CHECK(bytes_of(path) == std::string(text) + "+");
  }
  {
    FilePlace place(path);
    CHECK(place.take(FormerFile::replaced).empty());
    CHECK_FALSE(place.former_kept());
  }
  CHECK(bytes_of(path).empty());
  CHECK(bytes_of(path + ".previous") == "second+");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  CHECK_FALSE(std::filesystem::exists(path + ".previous.part"));
}

TEST_CASE("a file is taken by one process at a time, before and after it has its place") {
  const RingFolder folder;
  const std::string path = folder.file("log");
  {
    FilePlace place(path);
    CHECK(refusal(path).find("still going makes it") != std::string::npos);
    CHECK(place.take(FormerFile::kept).empty());
    CHECK(refusal(path).find("still going uses it") != std::string::npos);
  }
  CHECK(refusal(path).empty());
}

TEST_CASE("what a killed maker has left is in nobody's way, wherever it was killed") {
  const RingFolder folder;
  const std::string path = folder.file("log");
  write_bytes(path, "old");
  SECTION("a part of any content") { write_bytes(path + ".part", "half a lo"); }
  SECTION("a second name of the former file that had not got its own yet") {
    std::filesystem::create_hard_link(path, path + ".previous.part");
  }
  SECTION("a former file that has its new name while the old one is still there") {
    std::filesystem::create_hard_link(path, path + ".previous");
    write_bytes(path + ".part", "half");
  }
  SECTION("a link, which is not followed") {
    write_bytes(folder.file("letter"), "Dear mother");
    std::filesystem::create_symlink(folder.file("letter"), path + ".part");
  }
  {
    FilePlace place(path);
    put(place, "new");
    CHECK(bytes_of(path) == "old");
    CHECK(place.take(FormerFile::kept).empty());
  }
  CHECK(bytes_of(path) == "new");
  CHECK(bytes_of(path + ".previous") == "old");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  CHECK_FALSE(std::filesystem::exists(path + ".previous.part"));
  if (std::filesystem::exists(folder.file("letter"))) CHECK(bytes_of(folder.file("letter")) == "Dear mother");
}

TEST_CASE("a link leads to its file, a pipe is written itself, and a folder is refused") {
  const RingFolder folder;
  write_bytes(folder.file("data"), "old");
  std::filesystem::create_symlink(folder.file("data"), folder.file("link"));
  {
    FilePlace place(folder.file("link"));
    put(place, "new");
    CHECK(place.take(FormerFile::kept).empty());
  }
  CHECK(std::filesystem::is_symlink(folder.file("link")));
  CHECK(bytes_of(folder.file("data")) == "new");
  CHECK(bytes_of(folder.file("data.previous")) == "old");

  REQUIRE(mkfifo(folder.file("pipe").c_str(), 0600) == 0);
  const int reader = open(folder.file("pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  {
    FilePlace place(folder.file("pipe"));
    CHECK(place.taken());
    put(place, "news");
    CHECK(place.take(FormerFile::kept).empty());
  }
  char text[8]{};
  CHECK(read(reader, text, sizeof(text)) == 4);
  close(reader);
  CHECK(is_special_file(folder.file("pipe")));
  CHECK(is_special_file("/dev/null"));
  CHECK_FALSE(is_special_file(folder.file("data")));

  CHECK(refusal(folder.path).find("folder") != std::string::npos);
  CHECK(refusal(folder.file("no/such/folder")).find("directory that can be written") != std::string::npos);
}

TEST_CASE("a place that cannot be taken leaves the new file under the name that is told") {
  const RingFolder folder;
  const std::string path = folder.file("log");
  write_bytes(path, "old");
  std::filesystem::create_directories(path + ".previous/full");
  {
    FilePlace place(path);
    put(place, "new");
    const std::string why = place.take(FormerFile::kept);
    CHECK(why.find("cannot be moved") != std::string::npos);
    CHECK(why.find(path + ".part") != std::string::npos);
    CHECK_FALSE(place.taken());
  }
  CHECK(bytes_of(path) == "old");
  CHECK(bytes_of(path + ".part") == "new");
}

}  // namespace sortie::rt::posix
