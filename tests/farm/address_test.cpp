// Where the coordinator listens, and who may speak to it.
#include <gtest/gtest.h>

#include "tests/farm/farm.hpp"
#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {
namespace {

Outcome serve(std::vector<std::string> arguments) {
  const TemporaryFolder folder;
  std::vector<std::string> all{(programs() / "tessera-server").string(), "--data",
                               (folder / "data").string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return run(all, Seconds(5));
}

TEST(Address, off_loopback_needs_a_token) {
  const Outcome outcome = serve({"--http", "0.0.0.0:0", "--listen", "127.0.0.1:0"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("--token"), std::string::npos) << outcome.errors;
}

TEST(Address, off_loopback_without_tls_needs_insecure_as_well) {
  const Outcome outcome = serve(
      {"--http", "127.0.0.1:0", "--listen", "0.0.0.0:0", "--token", "a-token-that-is-long-enough"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("--insecure"), std::string::npos) << outcome.errors;
}

TEST(Address, a_port_in_use_is_said) {
  Farm farm;
  const Outcome outcome = serve({"--http", farm.http(), "--listen", "127.0.0.1:0"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.errors.find(farm.http()), std::string::npos) << outcome.errors;
}

TEST(Address, a_data_folder_in_use_is_said) {
  Farm farm;
  const Outcome outcome =
      run({(programs() / "tessera-server").string(), "--data", (farm.folder() / "data").string(),
           "--http", "127.0.0.1:0", "--listen", "127.0.0.1:0"},
          Seconds(10));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.errors.find((farm.folder() / "data").string()), std::string::npos)
      << outcome.errors;
}

TEST(Address, with_a_token_workers_and_clients_must_show_it) {
  const TemporaryFolder folder;
  const std::string token = "a-token-that-is-long-enough";
  Process server({(programs() / "tessera-server").string(), "--data", (folder / "data").string(),
                  "--http", "127.0.0.1:0", "--listen", "127.0.0.1:0", "--token", token},
                 folder / "server");
  for (int k = 0; k < 500 && server.output().find('\n') == std::string::npos; ++k)
    server.wait(Seconds(0.02));
  const std::string ready = server.output();
  const auto value = [&](const std::string& key) {
    const std::size_t at = ready.find('"', ready.find("\"" + key + "\"") + key.size() + 2);
    return ready.substr(at + 1, ready.find('"', at + 1) - at - 1);
  };
  const auto client = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{(programs() / "tessera").string(), "--server",
                                 "http://" + value("http")};
    all.insert(all.end(), more.begin(), more.end());
    return run(all, Seconds(10));
  };
  EXPECT_EQ(client({"jobs"}).code, 4);
  EXPECT_EQ(client({"--token", "wrong", "jobs"}).code, 4);
  EXPECT_EQ(client({"--token", token, "jobs"}).code, 0);

  const ScriptedWorker stranger(value("listen"));
  ASSERT_FALSE(stranger.welcomed());
  EXPECT_EQ(std::get<wire::Refused>(stranger.answer()).code, "token");
  ScriptedHello hello;
  hello.token = token;
  EXPECT_TRUE(ScriptedWorker(value("listen"), hello).welcomed());
}

TEST(Address, a_server_that_is_not_there_is_exit_code_3) {
  EXPECT_EQ(run({(programs() / "tessera").string(), "--server", "http://127.0.0.1:9", "jobs"},
                Seconds(30))
                .code,
            3);
}

}  // namespace
}  // namespace tessera::farm_test
