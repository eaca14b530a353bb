// The whole coordinator in process, on ports that it picks.
#include "server/server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_future.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/digest.hpp"
#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/random.hpp"
#include "common/net/http_client.hpp"
#include "server/options.hpp"
#include "server/quantities.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

std::string refusal(const ServerSettings& settings) {
  try {
    check(settings);
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    return error.what();
  }
}

TEST(Quantities, SizesAreReadAsPeopleWriteThem) {
  EXPECT_EQ(size_from("4096", "--x"), 4096U);
  EXPECT_EQ(size_from("512M", "--x"), 512U << 20);
  EXPECT_EQ(size_from("2GiB", "--x"), std::uint64_t{2} << 30);
  EXPECT_EQ(size_from("1.5KB", "--x"), 1536U);
  for (const char* text : {"", "0", "-1", "G", "4X", "4GG", "4 G", "1e30T", "nan"}) {
    try {
      static_cast<void>(size_from(text, "--disk-limit"));
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("--disk-limit"));
    }
  }
}

TEST(Quantities, TimesAreReadAsPeopleWriteThem) {
  EXPECT_EQ(time_from("90s", "--x"), std::optional<Duration>(std::chrono::seconds(90)));
  EXPECT_EQ(time_from("1.5h", "--x"), std::optional<Duration>(std::chrono::minutes(90)));
  EXPECT_EQ(time_from("30d", "--x"), std::optional<Duration>(std::chrono::hours(720)));
  EXPECT_EQ(time_from("2w", "--x"), std::optional<Duration>(std::chrono::hours(336)));
  EXPECT_EQ(time_from("forever", "--x"), std::nullopt);
  for (const char* text : {"", "7", "d", "-1d", "7 d", "7dd", "1e30w", "never"})
    EXPECT_THROW(static_cast<void>(time_from(text, "--keep-jobs")), Error) << text;
}

TEST(Quantities, MachineHasMemory) { EXPECT_GT(machine_memory(), std::uint64_t{64} << 20); }

TEST(ServerSettings, LoopbackNeedsNeitherTokenNorLeave) {
  ServerSettings settings;
  EXPECT_EQ(refusal(settings), "");
  settings.http.host = "::1";
  EXPECT_EQ(refusal(settings), "");
}

TEST(ServerSettings, OffLoopbackATokenIsAskedForThenLeaveToSpeakInTheClear) {
  for (const bool http : {true, false}) {
    ServerSettings settings;
    (http ? settings.http : settings.listen).host = "0.0.0.0";
    EXPECT_THAT(refusal(settings), HasSubstr("--token"));
    settings.insecure = true;
    EXPECT_THAT(refusal(settings), HasSubstr("--token"));
    settings.token = "short";
    EXPECT_THAT(refusal(settings), HasSubstr("at least 16"));
    settings.token = "a-token-that-is-long-enough";
    EXPECT_EQ(refusal(settings), "");
    settings.insecure = false;
    EXPECT_THAT(refusal(settings), HasSubstr("--insecure"));
  }
}

TEST(ServerSettings, WhatCannotBeIsRefused) {
  ServerSettings settings;
  settings.http.host = "render.example";
  EXPECT_THAT(refusal(settings), HasSubstr("IP address"));
  settings = {};
  settings.token = "with blanks in it";
  EXPECT_THAT(refusal(settings), HasSubstr("token"));
  settings = {};
  settings.public_url = "render.example:80";
  EXPECT_THAT(refusal(settings), HasSubstr("http://"));
}

ParsedOptions parsed(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tessera-server");
  return parse_options(static_cast<int>(arguments.size()), arguments.data());
}

TEST(ServerOptions, AreReadFromTheCommandLine) {
  const auto options = parsed({"--data", "/x", "--http", "localhost:0", "--listen", "[::1]:9",
                               "--token", "t", "--log-level", "warn"});
  ASSERT_TRUE(options.options);
  const ServerSettings& server = options.options->server;
  EXPECT_EQ(server.data, "/x");
  EXPECT_EQ(server.http.text(), "127.0.0.1:0");
  EXPECT_EQ(server.listen.text(), "[::1]:9");
  EXPECT_EQ(server.token, "t");
  EXPECT_EQ(options.options->log_level, log::Level::warn);
  EXPECT_TRUE(server.durable);
}

TEST(ServerOptions, WrongUsageIsExitCode2) {
  for (const auto& arguments :
       std::vector<std::vector<const char*>>{{"--nonsense"},
                                             {"--http", "127.0.0.1:99999"},
                                             {"--http", "0.0.0.0:1"},
                                             {"--log-level", "loud"},
                                             {"--pool-threads", "0"},
                                             {"--token-file", "/nowhere/at/all"}}) {
    const auto options = parsed(arguments);
    EXPECT_FALSE(options.options) << arguments.front();
    EXPECT_EQ(options.exit_code, 2) << arguments.front();
  }
}

/// One server on a thread of its own, and a client on another.
class WholeServer : public ::testing::Test {
 protected:
  WholeServer() { start(); }
  ~WholeServer() override {
    stop();
    std::filesystem::remove_all(folder);
  }
  void start() {
    ServerSettings settings;
    settings.data = folder;
    settings.http.port = 0;
    settings.listen.port = 0;
    settings.token = "sesame";
    server = std::make_unique<Server>(context, settings);
    thread = std::thread([this] { context.run(); });
  }
  void stop() {
    if (!server) return;
    boost::asio::co_spawn(context, server->stop(), boost::asio::use_future).get();
    context.stop();
    thread.join();
    server.reset();
    context.restart();
  }
  net::HttpResponse ask(const std::string& method, const std::string& target,
                        const std::string& body = {}) {
    boost::asio::io_context own;
    net::HttpClient client(own.get_executor(), "http://" + server->http().text(), "sesame");
    net::HttpRequest request;
    request.method = method;
    request.target = target;
    request.body = body;
    request.errors_throw = false;
    auto answer = boost::asio::co_spawn(own, client.send(request), boost::asio::use_future);
    own.run();
    return answer.get();
  }

  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tessera-server-" + random_hex(8));
  boost::asio::io_context context{1};
  std::unique_ptr<Server> server;
  std::thread thread;
};

TEST_F(WholeServer, SaysWhereItListensAndAnswersThere) {
  const Json line = Json::parse(server->ready_line());
  EXPECT_EQ(line["http"], server->http().text());
  EXPECT_NE(server->http().port, 0);
  EXPECT_NE(server->listen().port, 0);
  EXPECT_EQ(ask("GET", "/readyz").status, 200);
  EXPECT_EQ(Json::parse(ask("GET", "/v1/jobs").body)["jobs"].size(), 0U);
}

TEST_F(WholeServer, RefusesAJobWhoseBundleItDoesNotHave) {
  const std::string spec = R"({"name":"x","bundle":")" + std::string(64, 'a') +
                           R"(","render":{"width":8,"height":8,"samples":1}})";
  EXPECT_EQ(ask("POST", "/v1/jobs", spec).status, 409);
}

TEST_F(WholeServer, KeepsJobsOverAStart) {
  const std::string scene = "{}";
  const std::string digest = digest_of(scene).hex();
  const std::string manifest = R"({"files":{"scene.json":{"sha256":")" + digest +
                               R"(","size":2}},"scene":"scene.json","version":1})";
  const std::string bundle = digest_of(manifest).hex();
  EXPECT_EQ(ask("PUT", "/v1/blobs/" + digest, scene).status, 201);
  EXPECT_EQ(ask("PUT", "/v1/blobs/" + bundle, manifest).status, 201);
  const std::string spec =
      R"({"name":"kept","bundle":")" + bundle + R"(","render":{"width":8,"height":8,"samples":1}})";
  const net::HttpResponse posted = ask("POST", "/v1/jobs", spec);
  ASSERT_EQ(posted.status, 201) << posted.body;
  stop();
  start();
  const Json jobs = Json::parse(ask("GET", "/v1/jobs").body)["jobs"];
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0]["name"], "kept");
  EXPECT_EQ(
      Json::parse(
          ask("DELETE", "/v1/jobs/" + std::to_string(jobs[0]["id"].get<int>())).body)["state"],
      "cancelled");
}

TEST_F(WholeServer, ASecondOneOnTheSameFolderOrPortIsRefused) {
  boost::asio::io_context own;
  ServerSettings settings;
  settings.data = folder;
  settings.http.port = 0;
  settings.listen.port = 0;
  try {
    const Server second(own, settings);
    FAIL() << "two coordinators in one folder";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(folder.string()));
  }
  settings.data = folder.string() + "-other";
  settings.listen = server->listen();
  try {
    const Server second(own, settings);
    FAIL() << "two listen on one port";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(server->listen().text()));
  }
  std::filesystem::remove_all(settings.data);
}

}  // namespace
}  // namespace tessera::server
