#include "client/settings.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

TEST(Settings, flags_win_over_environment_over_config_over_defaults) {
  const GivenSettings none, flags{"http://f:1", "tf"}, environment{"http://e:1", "te"},
      config{"http://c:1", "tc"};
  EXPECT_EQ(settle(flags, environment, config, false).server, "http://f:1");
  EXPECT_EQ(settle(flags, environment, config, false).token, "tf");
  EXPECT_EQ(settle(none, environment, config, false).server, "http://e:1");
  EXPECT_EQ(settle(none, environment, config, false).token, "te");
  EXPECT_EQ(settle(none, none, config, true).server, "http://c:1");
  EXPECT_EQ(settle(none, none, none, false).server, "http://127.0.0.1:8420");
  EXPECT_EQ(settle(none, none, none, false).token, "");
  EXPECT_TRUE(settle(none, none, none, true).json);
}

TEST(Settings, who_named_the_server_is_known) {
  const GivenSettings none, token{std::nullopt, "t"}, given{"http://a:1", std::nullopt};
  EXPECT_EQ(settle(token, none, none, false).named, NamedBy::nobody);
  EXPECT_EQ(settle(given, given, given, false).named, NamedBy::flag);
  EXPECT_EQ(settle(none, given, given, false).named, NamedBy::environment);
  EXPECT_EQ(settle(none, none, given, false).named, NamedBy::config);
}

TEST(Settings, each_is_taken_from_the_first_that_has_it) {
  const Settings settings = settle({"http://f:1", std::nullopt}, {}, {"http://c:1", "tc"}, false);
  EXPECT_EQ(settings.server, "http://f:1");
  EXPECT_EQ(settings.token, "tc");
}

TEST(Settings, a_server_without_a_scheme_is_http) {
  EXPECT_EQ(settle({"farm:8420", std::nullopt}, {}, {}, false).server, "http://farm:8420");
  EXPECT_EQ(settle({"https://farm", std::nullopt}, {}, {}, false).server, "https://farm");
}

TEST(ConfigFile, gives_server_and_token) {
  const TemporaryFolder folder;
  const auto file = folder.write("config.json", R"({"server": "http://a:1", "token": "t"})");
  EXPECT_EQ(config_settings(file).server, "http://a:1");
  EXPECT_EQ(config_settings(file).token, "t");
}

TEST(ConfigFile, that_is_not_there_says_nothing) {
  EXPECT_FALSE(config_settings("/nowhere/config.json").server.has_value());
  EXPECT_FALSE(config_settings({}).server.has_value());
}

TEST(ConfigFile, mistakes_name_the_file_and_the_nearest_key) {
  const TemporaryFolder folder;
  const auto file = folder.write("config.json", R"({"serve": "http://a:1"})");
  const Error error = error_of([&] { (void)config_settings(file); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().file, file.string());
  EXPECT_NE(error.message().find("did you mean \"server\"?"), std::string::npos) << error.what();
  const auto broken = folder.write("broken.json", "{");
  EXPECT_EQ(error_of([&] { (void)config_settings(broken); }).place().file, broken.string());
}

TEST(ConfigFile, lies_in_the_xdg_folder_or_in_home) {
  setenv("XDG_CONFIG_HOME", "/x", 1);
  EXPECT_EQ(config_file(), "/x/tessera/config.json");
  unsetenv("XDG_CONFIG_HOME");
  setenv("HOME", "/home/me", 1);
  EXPECT_EQ(config_file(), "/home/me/.config/tessera/config.json");
}

TEST(Environment, empty_variables_say_nothing) {
  setenv("TESSERA_SERVER", "", 1);
  setenv("TESSERA_TOKEN", "abc", 1);
  EXPECT_FALSE(environment_settings().server.has_value());
  EXPECT_EQ(environment_settings().token, "abc");
  unsetenv("TESSERA_SERVER");
  unsetenv("TESSERA_TOKEN");
}

}  // namespace
}  // namespace tessera::client
