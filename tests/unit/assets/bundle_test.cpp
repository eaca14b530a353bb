#include "common/assets/bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"

namespace tessera::assets {
namespace {

using testing::HasSubstr;

Bundle sample() {
  Bundle bundle;
  bundle.scene = "cornell.json";
  bundle.files["meshes/b.obj"] = {.digest = digest_of("b"), .size = 1};
  bundle.files["cornell.json"] = {.digest = digest_of("scene"), .size = 5};
  return bundle;
}

std::string error_of(const std::string& json) {
  try {
    bundle_from_json(json);
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Bundle, its_json_is_always_the_same_bytes) {
  EXPECT_EQ(canonical_json(sample()),
            "{\"files\":{\"cornell.json\":{\"sha256\":\"" + digest_of("scene").hex() +
                "\",\"size\":5},\"meshes/b.obj\":{\"sha256\":\"" + digest_of("b").hex() +
                "\",\"size\":1}},\"scene\":\"cornell.json\",\"version\":1}");
  EXPECT_EQ(digest_of_bundle(sample()), digest_of(canonical_json(sample())));
}

TEST(Bundle, it_comes_back_from_its_json) {
  EXPECT_EQ(bundle_from_json(canonical_json(sample())), sample());
  EXPECT_EQ(total_size(sample()), 6U);
  EXPECT_EQ(blobs_of(sample()).size(), 2U);
}

TEST(Bundle, files_of_one_content_count_once) {
  Bundle bundle = sample();
  bundle.files["copy.obj"] = bundle.files["meshes/b.obj"];
  EXPECT_EQ(total_size(bundle), 6U);
  EXPECT_EQ(blobs_of(bundle).size(), 2U);
}

TEST(Bundle, a_file_that_is_named_by_path_is_no_blob) {
  Bundle bundle = sample();
  bundle.files["meshes/b.obj"].location = "/mnt/show/b.obj";
  EXPECT_EQ(bundle_from_json(canonical_json(bundle)), bundle);
  EXPECT_NE(digest_of_bundle(bundle), digest_of_bundle(sample()));
  EXPECT_EQ(blobs_of(bundle), std::vector<Digest>{digest_of("scene")});
  EXPECT_EQ(total_size(bundle), 6U);
  EXPECT_EQ(blob_size(bundle), 5U);
  for (const std::string location : {"", "b.obj", "/", "/mnt/../etc/b", "/mnt//b", "/mnt/./b"}) {
    std::string json = canonical_json(bundle);
    json.replace(json.find("/mnt/show/b.obj"), 15, location);
    EXPECT_THAT(error_of(json), testing::Ne("taken")) << location;
  }
}

TEST(Bundle, paths_that_lead_elsewhere_are_refused) {
  for (const std::string path : {"", "/etc/passwd", "../a", "a/../b", "a/..", "..", ".", "./a",
                                 "a/./b", "a//b", "a/", "C:a", "C:\\a", "a\\b", "a\nb", "a\x7f"})
    EXPECT_THROW(check_path(path), Error) << path;
  EXPECT_THROW(check_path(std::string("a\0b", 3)), Error);
  EXPECT_THROW(check_path(std::string(limits::bundle_path + 1, 'a')), Error);
  for (const std::string path : {"a", "a/b.obj", "..a", "a..", ".hidden", "ä/ö", "a b", "..."})
    EXPECT_NO_THROW(check_path(path)) << path;
  EXPECT_NO_THROW(check_path(std::string(limits::bundle_path, 'a')));
}

TEST(Bundle, what_is_wrong_in_its_json_is_named) {
  const std::string file = "{\"sha256\":\"" + digest_of("a").hex() + "\",\"size\":1}";
  const auto with = [&](const std::string& files, const std::string& scene = "a",
                        const std::string& more = "") {
    return error_of("{\"version\":1,\"scene\":\"" + scene + "\",\"files\":{" + files + "}" + more +
                    "}");
  };
  EXPECT_EQ(with("\"a\":" + file), "taken");
  EXPECT_THAT(with("\"a\":" + file, "b"), HasSubstr("scene"));
  EXPECT_THAT(with("\"a\":" + file + ",\"../x\":" + file), HasSubstr("../x"));
  EXPECT_THAT(with("\"a\":" + file + ",\"a/b\":" + file), HasSubstr("a/b"));
  EXPECT_THAT(with("\"a\":" + file + ",\"a\":" + file), HasSubstr("twice"));
  EXPECT_THAT(with("\"a\":{\"sha256\":\"12\",\"size\":1}"), HasSubstr("files.a.sha256"));
  EXPECT_THAT(with("\"a\":{\"sha256\":\"" + digest_of("a").hex() + "\",\"size\":-1}"),
              HasSubstr("files.a.size"));
  EXPECT_THAT(with("\"a\":{\"size\":1}"), HasSubstr("files.a.sha256"));
  EXPECT_THAT(with("\"a\":" + file, "a", ",\"extra\":1"), HasSubstr("extra"));
  EXPECT_THAT(error_of("{\"version\":2,\"scene\":\"a\",\"files\":{}}"), HasSubstr("version"));
  EXPECT_THAT(error_of("{\"version\":1,\"scene\":\"a\",\"files\":[]}"), HasSubstr("files"));
  EXPECT_THAT(error_of("not json"), HasSubstr("bundle"));
}

TEST(Bundle, it_has_a_limit_of_files) {
  Bundle bundle = sample();
  for (std::size_t i = 0; bundle.files.size() <= limits::bundle_files; ++i)
    bundle.files["f" + std::to_string(i)] = {};
  EXPECT_THROW(check(bundle), Error);
}

}  // namespace
}  // namespace tessera::assets
