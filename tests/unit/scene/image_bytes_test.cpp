#include "common/scene/image_bytes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tessera::scene {
namespace {

Image part(const std::filesystem::path& file, std::uint64_t offset, std::uint64_t size) {
  return {"model.glb: /images/2", FileRange{file, offset, size}};
}

std::string text_of(const Image& image) {
  const auto bytes = encoded_bytes(image);
  return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

TEST(ImageBytes, AreAPartOfAFileOrAllFromAPlaceOnOrWhatIsHeld) {
  const TemporaryFolder folder;
  const auto file = folder.write("model.glb", "0123456789");
  EXPECT_EQ(text_of(part(file, 3, 4)), "3456");
  EXPECT_EQ(text_of(part(file, 3, 0)), "3456789");
  EXPECT_EQ(encoded_size(part(file, 3, 4)), 4U);
  EXPECT_EQ(encoded_size(part(file, 3, 0)), 7U);
  const auto held = std::make_shared<const std::vector<std::byte>>(5);
  EXPECT_EQ(encoded_bytes({"data", held}), held) << "without a copy";
  EXPECT_EQ(encoded_size({"data", held}), 5U);
}

TEST(ImageBytes, WhatCannotBeHadIsSaidOfTheImage) {
  const TemporaryFolder folder;
  const auto file = folder.write("model.glb", "0123456789");
  const auto huge = folder.write("huge.png", "");
  std::filesystem::resize_file(huge, limits::image_file_bytes + 1);  // a hole
  const auto expect = [](const Image& image, ErrorKind kind, const std::string& words) {
    try {
      encoded_bytes(image);
      ADD_FAILURE() << "no error, expected: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind);
      EXPECT_EQ(error.place().file, "model.glb: /images/2");
      EXPECT_THAT(error.message(), testing::HasSubstr(words));
    }
  };
  expect(part(folder / "none.glb", 0, 0), ErrorKind::not_found, "No such file");
  expect(part(file, 3, 8), ErrorKind::bad_input, "beyond the end of its file");
  expect(part(file, 11, 0), ErrorKind::bad_input, "beyond the end of its file");
  expect(part(file, 1, UINT64_MAX), ErrorKind::bad_input, "beyond the end of its file");
  expect(part(huge, 0, 0), ErrorKind::too_large, "a picture's file may have");
}

}  // namespace
}  // namespace tessera::scene
