#include "server/http/routes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "common/base/error.hpp"
#include "server/http/openapi.hpp"

namespace tessera::server {
namespace {

TEST(Target, IsSplitAndItsEscapesUndone) {
  const Target target = parse_target("/v1/a%2Fb/?x=1%202&flag");
  EXPECT_THAT(target.segments, testing::ElementsAre("v1", "a/b"));
  EXPECT_EQ(target.parameter("x"), "1 2");
  EXPECT_EQ(target.parameter("flag"), "");
  EXPECT_FALSE(target.parameter("y"));
}

TEST(Target, BrokenOnesAreRefused) {
  for (const char* target :
       {"", "v1", "http://other/", "*", "/%", "/%4", "/%zz", "/a%0ab", "/?a=1&a=2"})
    EXPECT_THROW(parse_target(target), Error) << target;
}

TEST(Routes, APathIsFoundByMethodAndItsValuesAreGiven) {
  const RouteMatch match =
      find_route("GET", parse_target("/v1/jobs/12/frames/-3/image.png?exposure=1"));
  ASSERT_NE(match.route, nullptr);
  EXPECT_EQ(match.route->pattern, "/v1/jobs/{id}/frames/{frame}/image.png");
  EXPECT_THAT(match.values, testing::ElementsAre("12", "-3"));
}

TEST(Routes, AnotherMethodIsToldWhichThereAre) {
  const RouteMatch match = find_route("PUT", parse_target("/v1/jobs/12"));
  EXPECT_EQ(match.route, nullptr);
  EXPECT_EQ(match.allow, "GET, PATCH, DELETE, HEAD");
  EXPECT_EQ(find_route("PUT", parse_target("/v1/nowhere")).allow, "");
}

TEST(Routes, ALiteralPathHidesAPatternThatWouldFit) {
  const RouteMatch match = find_route("GET", parse_target("/v1/blobs/missing"));
  EXPECT_EQ(match.route, nullptr);
  EXPECT_EQ(match.allow, "POST");
}

TEST(Routes, HeadIsAnsweredWhereGetIs) {
  EXPECT_EQ(find_route("HEAD", parse_target("/v1/jobs")).route->method, "GET");
  const std::string blob = "/v1/blobs/" + std::string(64, 'a');
  EXPECT_EQ(find_route("HEAD", parse_target(blob)).route->method, "HEAD");
}

TEST(Routes, OnlyReadingABlobIsOpenToTheBlobToken) {
  for (const Route& route : routes()) {
    const bool blob_read = route.pattern == "/v1/blobs/{sha256}" && route.method != "PUT";
    EXPECT_EQ(route.role == Role::blob_reader, blob_read) << route.method << " " << route.pattern;
  }
}

TEST(OpenApi, DescribesEveryRouteOfTheTableWithItsParameters) {
  const Json description = openapi_description(routes());
  std::size_t operations = 0;
  for (const auto& [path, methods] : description["paths"].items()) operations += methods.size();
  EXPECT_EQ(operations, routes().size());
  const Json& tiles = description["paths"]["/v1/jobs/{id}/frames/{frame}/tiles"]["get"];
  std::set<std::string> names;
  for (const Json& parameter : tiles["parameters"]) names.insert(parameter["name"]);
  EXPECT_EQ(names, (std::set<std::string>{"id", "frame", "since"}));
  const Json& submit = description["paths"]["/v1/jobs"]["post"];
  ASSERT_EQ(submit["parameters"].size(), 1U);
  EXPECT_EQ(submit["parameters"][0]["name"], "Idempotency-Key");
  EXPECT_EQ(submit["parameters"][0]["in"], "header");
  EXPECT_FALSE(submit["parameters"][0]["required"]);
  EXPECT_TRUE(submit["responses"].contains("422"));
}

TEST(OpenApi, Lists507WhereTheServerKeepsSomethingAndNowhereElse) {
  const Json description = openapi_description(routes());
  for (const auto& [path, methods] : description["paths"].items())
    for (const auto& [method, operation] : methods.items()) {
      const bool keeps = method != "get" && method != "head" && path != "/v1/blobs/missing";
      EXPECT_EQ(operation["responses"].contains("507"), keeps) << method << " " << path;
    }
}

}  // namespace
}  // namespace tessera::server
