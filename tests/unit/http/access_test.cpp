#include "server/http/access.hpp"

#include <gtest/gtest.h>

namespace tessera::server {
namespace {

HttpRequest request_with(const HttpFields& fields, const std::string& method = "GET") {
  HttpRequest request;
  request.method = method;
  request.fields = fields;
  return request;
}

AccessSettings on_loopback() {
  AccessSettings settings;
  settings.port = 8420;
  return settings;
}

unsigned origin_status(const HttpFields& fields, const AccessSettings& settings,
                       const std::string& method = "GET") {
  const auto refusal = check_origin(request_with(fields, method), settings);
  return refusal ? refusal->status : 200;
}

unsigned token_status(const HttpFields& fields, Role role, const AccessSettings& settings) {
  const auto refusal = check_token(request_with(fields), role, settings);
  return refusal ? refusal->status : 200;
}

TEST(Host, NamesOfLoopbackWithThePortAreGood) {
  for (const char* host :
       {"127.0.0.1:8420", "localhost:8420", "LOCALHOST:8420", "[::1]:8420", "127.0.0.9:8420"})
    EXPECT_EQ(origin_status({{"host", host}}, on_loopback()), 200U) << host;
}

TEST(Host, EverythingElseOnLoopbackIsMisdirected) {
  for (const char* host :
       {"evil.example:8420", "evil.example", "localhost", "localhost:80", "127.evil.example:8420",
        "", "localhost.evil.example:8420", "127.0.0.1:8420.evil.example", "0.0.0.0:8420"})
    EXPECT_EQ(origin_status({{"host", host}}, on_loopback()), 421U) << host;
}

TEST(Host, MustStandThereOnce) {
  EXPECT_EQ(origin_status({}, on_loopback()), 400U);
  EXPECT_EQ(origin_status({{"host", "localhost:8420"}, {"host", "localhost:8420"}}, on_loopback()),
            400U);
}

TEST(Host, ThePublicUrlsIsGoodToo) {
  AccessSettings settings = on_loopback();
  settings.public_url = "https://Farm.example/tessera";
  EXPECT_EQ(origin_status({{"host", "farm.example"}}, settings), 200U);
  EXPECT_EQ(origin_status({{"host", "farm.example:1"}}, settings), 421U);
}

TEST(Host, OffLoopbackTheTokenGuardsAlone) {
  AccessSettings settings = on_loopback();
  settings.loopback = false;
  EXPECT_EQ(origin_status({{"host", "render-1:8420"}}, settings), 200U);
}

TEST(Origin, AForeignOneIsRefusedOnEveryMethod) {
  for (const char* method : {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
    for (const char* origin :
         {"http://evil.example", "null", "http://localhost:3000", "http://127.0.0.1:8421"})
      EXPECT_EQ(
          origin_status({{"host", "localhost:8420"}, {"origin", origin}}, on_loopback(), method),
          403U)
          << method << origin;
}

TEST(Origin, TheServersOwnIsGood) {
  EXPECT_EQ(origin_status({{"host", "localhost:8420"}, {"origin", "http://localhost:8420"}},
                          on_loopback(), "POST"),
            200U);
}

TEST(Origin, OtherSitesMayOpenThePageAndNothingElse) {
  const HttpFields image = {
      {"host", "localhost:8420"}, {"sec-fetch-site", "cross-site"}, {"sec-fetch-mode", "no-cors"}};
  EXPECT_EQ(origin_status(image, on_loopback()), 403U);
  const HttpFields frame = {{"host", "localhost:8420"},
                            {"sec-fetch-site", "same-site"},
                            {"sec-fetch-mode", "navigate"},
                            {"sec-fetch-dest", "iframe"}};
  EXPECT_EQ(origin_status(frame, on_loopback()), 403U);
  const HttpFields link = {{"host", "localhost:8420"},
                           {"sec-fetch-site", "cross-site"},
                           {"sec-fetch-mode", "navigate"},
                           {"sec-fetch-dest", "document"}};
  EXPECT_EQ(origin_status(link, on_loopback()), 200U);
  EXPECT_EQ(origin_status(link, on_loopback(), "POST"), 403U);
}

class Token : public ::testing::Test {
 protected:
  Token() {
    settings.token = "sesame";
    settings.blob_token = "reader";
  }
  AccessSettings settings = on_loopback();
};

TEST_F(Token, IsAskedOfEveryRequestWhereThereIsOne) {
  EXPECT_EQ(token_status({}, Role::user, settings), 401U);
  EXPECT_EQ(token_status({{"authorization", "Bearer sesam"}}, Role::user, settings), 401U);
  EXPECT_EQ(token_status({{"authorization", "Basic sesame"}}, Role::user, settings), 401U);
  EXPECT_EQ(token_status({{"authorization", "Bearer sesame"}}, Role::user, settings), 200U);
  EXPECT_EQ(token_status({{"authorization", "bearer sesame"}}, Role::blob_reader, settings), 200U);
  EXPECT_EQ(token_status({}, Role::user, on_loopback()), 200U);
}

TEST_F(Token, OfBlobsOpensNothingElse) {
  EXPECT_EQ(token_status({{"authorization", "Bearer reader"}}, Role::blob_reader, settings), 200U);
  EXPECT_EQ(token_status({{"authorization", "Bearer reader"}}, Role::user, settings), 403U);
}

TEST_F(Token, AnEmptyBlobTokenOpensNothing) {
  settings.blob_token.clear();
  EXPECT_EQ(token_status({{"authorization", "Bearer "}}, Role::blob_reader, settings), 401U);
}

TEST_F(Token, OfThePageBecomesACookieThatIsNotTheToken) {
  const auto entry = exchange_token("sesame", "/", settings);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->status, 303U);
  EXPECT_EQ(entry->field("Location"), "/");
  const std::string cookie(entry->field("Set-Cookie").value_or(""));
  EXPECT_EQ(cookie.find("sesame"), std::string::npos);
  EXPECT_NE(cookie.find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie.find("SameSite=Strict"), std::string::npos);
  const std::string pair = cookie.substr(0, cookie.find(';'));
  EXPECT_EQ(token_status({{"cookie", "other=1; " + pair}}, Role::user, settings), 200U);
  EXPECT_EQ(token_status({{"cookie", pair + "0"}}, Role::user, settings), 401U);
  settings.port = 9000;  // a cookie of another server on this machine
  EXPECT_EQ(token_status({{"cookie", pair}}, Role::user, settings), 401U);
}

TEST_F(Token, AWrongOneIsNotExchanged) {
  EXPECT_FALSE(exchange_token("sesam", "/", settings));
  EXPECT_FALSE(exchange_token("", "/", on_loopback()));
}

}  // namespace
}  // namespace tessera::server
