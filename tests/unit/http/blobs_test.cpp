#include "api_fixture.hpp"
#include "common/base/digest.hpp"
#include "common/base/limits.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class BlobsTest : public ApiTest {
 protected:
  static std::string bytes_of(std::size_t size) {
    std::string out(size, '\0');
    std::uint32_t state = 1;
    for (char& c : out) c = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24);
    return out;
  }
  std::string content = bytes_of(300'000);
  std::string path = "/v1/blobs/" + digest_of(content).hex();
};

TEST_F(BlobsTest, ABlobThatIsPutCanBeReadBack) {
  const HttpResponse put = ask("PUT", path, content);
  EXPECT_EQ(put.status, 201U);
  EXPECT_EQ(json(put)["size"], content.size());
  EXPECT_EQ(text(ask("GET", path)), content);
  const HttpResponse head = ask("HEAD", path);
  EXPECT_EQ(head.status, 200U);
  EXPECT_EQ(head.length(), content.size());
}

TEST_F(BlobsTest, ABlobThatIsThereIsNotReadAgain) {
  ask("PUT", path, content);
  TextBody again(content);
  EXPECT_EQ(ask_with("PUT", path, again).status, 200U);
  EXPECT_EQ(again.bytes_read(), 0U);
}

TEST_F(BlobsTest, AnEmptyBlobIsABlob) {
  const std::string empty = "/v1/blobs/" + digest_of(std::string_view()).hex();
  EXPECT_EQ(ask("PUT", empty, "").status, 201U);
  EXPECT_EQ(text(ask("GET", empty)), "");
}

TEST_F(BlobsTest, OtherBytesAreRefusedAndForgotten) {
  const HttpResponse wrong = ask("PUT", path, content + "x");
  EXPECT_EQ(wrong.status, 422U);
  EXPECT_EQ(wrong.field("Upload-Offset"), "0");
  EXPECT_EQ(ask("HEAD", path).field("Upload-Offset"), "0");
  EXPECT_EQ(ask("PUT", path, content).status, 201U);
}

TEST_F(BlobsTest, AnUploadThatBrokeOffGoesOnWhereItWas) {
  TextBody first(content, 100'000);
  first.breaks_at = 200'000;
  EXPECT_EQ(ask_with("PUT", path, first).status, 400U);
  const HttpResponse head = ask("HEAD", path);
  EXPECT_EQ(head.status, 404U);
  EXPECT_EQ(head.field("Upload-Offset"), "200000");
  const HttpResponse rest =
      ask("PUT", path, content.substr(200'000), {{"upload-offset", "200000"}});
  EXPECT_EQ(rest.status, 201U);
  EXPECT_EQ(text(ask("GET", path)), content);
}

TEST_F(BlobsTest, PartsAreKeptUntilTheLengthIsReached) {
  const std::string total = std::to_string(content.size());
  const HttpResponse part = ask("PUT", path, content.substr(0, 1000), {{"upload-length", total}});
  EXPECT_EQ(part.status, 202U);
  EXPECT_EQ(part.field("Upload-Offset"), "1000");
  const HttpFields rest = {{"upload-length", total}, {"upload-offset", "1000"}};
  EXPECT_EQ(ask("PUT", path, content.substr(1000), rest).status, 201U);
}

TEST_F(BlobsTest, APartThatWouldLeaveAGapIsRefusedWithTheRightOffset) {
  ask("PUT", path, content.substr(0, 1000), {{"upload-length", std::to_string(content.size())}});
  const HttpResponse gap = ask("PUT", path, content.substr(2000), {{"upload-offset", "2000"}});
  EXPECT_EQ(gap.status, 409U);
  EXPECT_EQ(gap.field("Upload-Offset"), "1000");
}

TEST_F(BlobsTest, AWholeBodyIsGoodAlthoughAPartIsKept) {
  ask("PUT", path, content.substr(0, 200'000), {{"upload-length", std::to_string(content.size())}});
  EXPECT_EQ(ask("PUT", path, content).status, 201U);
  EXPECT_EQ(text(ask("GET", path)), content);
}

TEST_F(BlobsTest, SizesBeyondTheLimitAreRefusedBeforeAnythingIsKept) {
  EXPECT_EQ(ask("PUT", path, "x", {{"upload-length", "99999999999999"}}).status, 413U);
  EXPECT_EQ(ask("PUT", path, "xx", {{"upload-length", "1"}}).status, 413U);
  EXPECT_EQ(ask("PUT", path, "x", {{"upload-offset", "-1"}}).status, 400U);
  EXPECT_EQ(ask("HEAD", path).field("Upload-Offset"), "0");
}

TEST_F(BlobsTest, ANameThatIsNoDigestIsRefused) {
  for (const char* method : {"GET", "HEAD", "PUT"})
    EXPECT_EQ(ask(method, "/v1/blobs/..%2fetc", "x").status, 400U) << method;
}

TEST_F(BlobsTest, ARangeIsCutOut) {
  ask("PUT", path, content);
  const HttpResponse middle = ask("GET", path, {}, {{"range", "bytes=10-19"}});
  EXPECT_EQ(middle.status, 206U);
  EXPECT_EQ(text(middle), content.substr(10, 10));
  EXPECT_EQ(middle.field("Content-Range"), "bytes 10-19/300000");
  EXPECT_EQ(text(ask("GET", path, {}, {{"range", "bytes=299990-"}})), content.substr(299'990));
  EXPECT_EQ(text(ask("GET", path, {}, {{"range", "bytes=-5"}})), content.substr(299'995));
  EXPECT_EQ(text(ask("GET", path, {}, {{"range", "bytes=299990-999999999"}})),
            content.substr(299'990));
}

TEST_F(BlobsTest, ARangeBeyondTheEndIs416AndOneNotUnderstoodIsIgnored) {
  ask("PUT", path, content);
  const HttpResponse beyond = ask("GET", path, {}, {{"range", "bytes=300000-"}});
  EXPECT_EQ(beyond.status, 416U);
  EXPECT_EQ(beyond.field("Content-Range"), "bytes */300000");
  for (const char* odd : {"bytes=5-2", "bytes=a-b", "lines=1-2", "bytes=1-2,4-5", "bytes=-"})
    EXPECT_EQ(ask("GET", path, {}, {{"range", odd}}).status, 200U) << odd;
}

TEST_F(BlobsTest, AreForEverAndHaveTheirDigestAsETag) {
  ask("PUT", path, content);
  const HttpResponse blob = ask("GET", path);
  EXPECT_EQ(blob.field("ETag"), "\"" + digest_of(content).hex() + "\"");
  EXPECT_THAT(std::string(blob.field("Cache-Control").value_or("")), HasSubstr("immutable"));
  EXPECT_EQ(ask("GET", path, {}, {{"if-none-match", std::string(*blob.field("ETag"))}}).status,
            304U);
}

TEST_F(BlobsTest, ThoseThatAreLackingAreTold) {
  ask("PUT", path, content);
  const std::string other(64, 'b');
  Json body = Json::object();
  body["digests"] = {digest_of(content).hex(), other};
  const Json answer = json(ask("POST", "/v1/blobs/missing", body.dump()));
  EXPECT_EQ(answer["missing"], Json::array({other}));
}

TEST_F(BlobsTest, AListOfDigestsIsChecked) {
  const auto problem = json(ask("POST", "/v1/blobs/missing", R"({"digests":["x"]})"));
  EXPECT_EQ(problem["status"], 400);
  EXPECT_EQ(problem["place"]["key"], "digests[0]");
  EXPECT_EQ(ask("POST", "/v1/blobs/missing", R"({"digests":"x"})").status, 400U);
  EXPECT_EQ(ask("POST", "/v1/blobs/missing", R"({"digest":[]})").status, 400U);
}

}  // namespace
}  // namespace tessera::server
