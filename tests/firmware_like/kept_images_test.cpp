// SPDX-License-Identifier: BSD-3-Clause
// Files of height images that a run is begun with and cannot use, and how an answer of images is told.
#include <catch2/catch.hpp>

#include "firmware_like/parts/recognise_images_output.hpp"
#include "tests/firmware_like/recognise_images_rig.hpp"

namespace sortie::testing {

TEST_CASE("an answer that only images made says so, whatever it is") {
  using mapping::ImageVerdict;
  using rt::RecognisedPlace;
  const std::pair<ImageVerdict, std::uint8_t> told[] = {
      {ImageVerdict::found, RecognisedPlace::kUnverified},
      {ImageVerdict::few, RecognisedPlace::kFew},
      {ImageVerdict::unlike, RecognisedPlace::kInconsistent},
      {ImageVerdict::narrow, RecognisedPlace::kNarrow},
      {ImageVerdict::ambiguous, RecognisedPlace::kAmbiguous},
      {ImageVerdict::undecided, RecognisedPlace::kUndecided}};
  for (const auto& [verdict, segments] : told) CHECK(firmware::verdict_of(verdict) == segments + 16);
  CHECK(firmware::verdict_of(ImageVerdict::none) == RecognisedPlace::kNone);

  // Of a search that ended without a place nothing of the one before is left.
  mapping::ImageSearch search({});
  std::vector<std::byte> memory(1 << 14);
  rt::Arena arena(memory);
  const mapping::ImageStore store({.images = 1}, arena);
  search.begin({});
  std::uint64_t units = 1'000'000;
  REQUIRE(search.run(store, units));
  firmware::RecogniseImagesOutput output;
  output.share = output.agree = output.rival = 7;
  output.covariance[5] = 1;
  firmware::put_answer(output, search, 3, {}, 123);
  CHECK(output.verdict == RecognisedPlace::kFew + RecognisedPlace::kByImages);
  CHECK(output.stamp_ns == 123);
  CHECK(output.pairs == 3);
  CHECK(output.agree + output.rival + output.speaking == 0);
  CHECK(output.share + output.covariance[5] == 0.0);
}

TEST_CASE("images that cannot be used are refused with their cure") {
  const TempFolder folder;
  const std::string nothing = folder.file("nothing.images"), text = folder.file("text.images"),
                    cut = folder.file("cut.images"), other = folder.file("other.images"),
                    many = folder.file("many.images"), bent = folder.file("bent.images");
  write(text, std::vector<std::uint8_t>(40, 'x'));
  std::vector<std::byte> memory(1 << 20);
  rt::Arena arena(memory);
  mapping::ImageStore store({.images = 4}, arena);
  const mapping::KeyFramePose pose;
  REQUIRE(store.put({}, pose, 0, 0) == Status::ok);
  const std::vector<std::uint8_t> whole = image_bytes(store);
  const auto with = [&whole](std::size_t byte, std::uint8_t value) {
    std::vector<std::uint8_t> bytes = whole;
    bytes[byte] = value;
    return bytes;
  };
  std::vector<std::uint8_t> shorter = whole;
  shorter.pop_back();
  write(cut, shorter);
  write(other, with(8, 77));    // the version
  write(many, with(23, 0xff));  // 4 thousand million images
  write(bent, with(100, whole[100] ^ 1));
  const auto refused = [&](const firmware::KeptMapPaths& maps, std::vector<std::string> more) {
    more.insert(more.begin(), "tasks.recognise_images.enabled=true");
    return message_of<std::runtime_error>([&] { static_cast<void>(run_recognising(1, "", maps, more)); });
  };
  CHECK(mentions(refused({"", "", nothing}, {}),
                 "cannot be read; make it with `sortie export images LOG -o FILE`"));
  CHECK(mentions(refused({"", "", text}, {}), "holds no images"));
  CHECK(mentions(refused({cut, "", ""}, {}), "holds images: give it with --images"));
  CHECK(mentions(refused({"", cut, ""}, {}), "holds images: give it with --images"));
  CHECK(mentions(refused({"", "", cut}, {}), "cut off, or too long"));
  CHECK(mentions(refused({"", "", other}, {}), "of another version"));
  CHECK(mentions(refused({"", "", many}, {}), "cut off, or too long"));
  CHECK(mentions(refused({"", "", bent}, {}), "damaged"));
  CHECK(mentions(refused({"", "", bent}, {}), "make it again with `sortie export images LOG -o FILE`"));
  CHECK(mentions(refused({"", "", cut}, {"tasks.recognise_images.enabled=false"}),
                 "add --set tasks.recognise_images.enabled=true"));
  CHECK(mentions(refused({}, {"tasks.map.enabled=false", "tasks.recognise.enabled=false"}), "map"));
}

}  // namespace sortie::testing
