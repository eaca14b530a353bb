#include "common/base/digest.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "common/base/crc32c.hpp"
#include "common/base/error.hpp"
#include "common/base/files.hpp"

namespace tessera {
namespace {

/// FIPS 180-4's examples.
TEST(Sha256, gives_the_published_digests) {
  EXPECT_EQ(digest_of("").hex(),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digest_of("abc").hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(digest_of(std::string(1'000'000, 'a')).hex(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, does_not_depend_on_how_the_bytes_are_cut) {
  Sha256 sha;
  sha.update("a");
  sha.update("");
  sha.update("bc");
  EXPECT_EQ(sha.finish(), digest_of("abc"));
}

TEST(Digest, is_read_back_from_hexadecimal_of_either_case_and_from_nothing_else) {
  const Digest digest = digest_of("abc");
  EXPECT_EQ(Digest::from_hex(digest.hex()), digest);
  EXPECT_EQ(Digest::from_hex("BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD"),
            digest);
  EXPECT_FALSE(Digest::from_hex(""));
  EXPECT_FALSE(Digest::from_hex(digest.hex() + "0"));
  EXPECT_FALSE(Digest::from_hex(digest.hex().substr(1)));
  EXPECT_FALSE(Digest::from_hex("g" + digest.hex().substr(1)));
}

TEST(DigestOfFile, is_that_of_its_bytes_and_an_error_names_the_file) {
  const auto path = std::filesystem::path(testing::TempDir()) / "tessera_digest_test";
  const std::string text(700'001, 'q');  // several pieces, the last one short
  write_file_atomically(path, text);
  EXPECT_EQ(digest_of_file(path), digest_of(text));
  std::filesystem::remove(path);
  try {
    digest_of_file(path);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::not_found);
    EXPECT_EQ(error.place().file, path.string());
  }
  EXPECT_THROW(digest_of_file(testing::TempDir()), Error) << "a folder";
}

std::uint32_t crc_of(std::string_view text, std::uint32_t before = 0) {
  return crc32c(std::as_bytes(std::span(text.data(), text.size())), before);
}

/// The check value of the catalogue, and RFC 3720, appendix B.4.
TEST(Crc32c, gives_the_published_values) {
  EXPECT_EQ(crc_of("123456789"), 0xE3069283U);
  EXPECT_EQ(crc_of(std::string(32, '\0')), 0x8A9136AAU);
  EXPECT_EQ(crc_of(std::string(32, '\xff')), 0x62A8AB43U);
  EXPECT_EQ(crc_of(""), 0U);
}

TEST(Crc32c, goes_on_where_an_earlier_piece_ended) {
  const std::string text(1000, 'x');
  for (const std::size_t cut : {0U, 1U, 7U, 512U, 1000U})
    EXPECT_EQ(crc_of(text.substr(cut), crc_of(text.substr(0, cut))), crc_of(text)) << cut;
}

}  // namespace
}  // namespace tessera
