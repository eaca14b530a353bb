#include "client/command_line.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <vector>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

/// What a command line does that reaches no server.
struct Outcome {
  int code = 0;
  std::string output, errors;
};

Outcome outcome_of(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tessera");
  setenv("XDG_CONFIG_HOME", "/nowhere", 1);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome out;
  out.code = run(static_cast<int>(arguments.size()), arguments.data());
  out.errors = testing::internal::GetCapturedStderr();
  out.output = testing::internal::GetCapturedStdout();
  return out;
}

TEST(CommandLine, every_command_has_help) {
  for (const char* command :
       {"render", "wedge", "submit", "watch", "wait", "fetch", "jobs", "workers", "focus", "set",
        "cancel", "purge", "quarantine", "release", "pause", "resume"}) {
    const Outcome out = outcome_of({command, "--help"});
    EXPECT_EQ(out.code, 0) << command;
    EXPECT_NE(out.output.find(command), std::string::npos) << out.output;
    EXPECT_EQ(out.errors, "");
  }
  const Outcome out = outcome_of({"--help"});
  EXPECT_EQ(out.code, 0);
  for (const char* part :
       {"render", "--server", "--token", "--json", "TESSERA_SERVER", "Exit codes", "config.json"})
    EXPECT_NE(out.output.find(part), std::string::npos) << part;
}

TEST(CommandLine, wrong_usage_is_code_2_and_says_what) {
  struct Wrong {
    std::vector<const char*> arguments;
    const char* part;
  };
  for (const Wrong& wrong : std::vector<Wrong>{
           {{"rendr"}, "unknown command \"rendr\"; did you mean \"render\"?"},
           {{"--server", "http://x", "rendr"}, "did you mean \"render\"?"},
           {{"render", "a.json", "--sampels", "4"},
            "unknown flag \"--sampels\"; did you mean "
            "\"--samples\"?"},
           {{"submit", "a.json", "--light-sampels=4"}, "did you mean \"--light-samples\"?"},
           {{"--sever", "http://x", "jobs"}, "did you mean \"--server\"?"},
           {{"jobs", "--jsno"}, "did you mean \"--json\"?"},
           {{"wedge", "a.json", "-o", "/tmp/a.png"}, "--vary"},
           {{"wedge", "a.json", "-o", "/tmp/a.exr", "--vary", "samples=1,2"}, "is a .png"},
           {{"wedge", "a.json", "-o", "/tmp/a.png", "--vary", "samples"}, "NAME=VALUE"},
           {{"wedge", "a.json", "-o", "/tmp/a.png", "--vary", "samples=1,2", "--samples", "4"},
            "a flag fixes"},
           {{"wedge", "a.json", "-o", "/tmp/a.png", "--vary", "seed=1,2", "--server", "http://x",
             "--workers", "2"},
            "beside --server"},
           {{}, "subcommand is required"},
           {{"render"}, "required"},
           {{"render", "a.json"}, "--output"},
           {{"render", "a.json", "-o", "/tmp/a.exr", "--samples", "many"}, "--samples"},
           {{"render", "a.json", "-o", "/tmp/a.exr", "--workers", "0"}, "--workers"},
           {{"render", "a.json", "-o", "/tmp/a.jpg"}, ".exr or .png"},
           {{"render", "a.json", "-o", "/tmp/a.exr", "--size", "10"}, "WIDTHxHEIGHT"},
           {{"render", "/nowhere/a.json", "-o", "/tmp/a.exr"}, "no folder \"/nowhere\""},
           {{"submit", "/tmp/no-such-scene.json"}, "no file \"/tmp/no-such-scene.json\""},
           {{"watch", "seven"}, "a job's number"},
           {{"wait", "0"}, "a job's number"},
           {{"cancel"}, "required"},
           {{"jobs", "--server", "ftp://x"}, "ftp"}}) {
    const Outcome out = outcome_of(wrong.arguments);
    EXPECT_EQ(out.code, 2) << out.errors;
    EXPECT_EQ(out.errors.rfind("tessera: ", 0), 0U) << out.errors;
    EXPECT_NE(out.errors.find(wrong.part), std::string::npos)
        << wrong.part << " not in " << out.errors;
    EXPECT_EQ(out.output, "");
  }
}

TEST(CommandLine, a_broken_scene_is_code_2_with_its_place) {
  const TemporaryFolder folder;
  const std::string file = folder.write("s.json", "{\"tessera\": 1,\n \"camra\": {}}").string();
  for (const char* command : {"submit", "render"}) {
    std::vector<const char*> arguments{command, file.c_str()};
    const std::string output = (folder.path() / "o.exr").string();
    if (std::string_view(command) == "render")
      arguments.insert(arguments.end(), {"-o", output.c_str()});
    const Outcome out = outcome_of(arguments);
    EXPECT_EQ(out.code, 2);
    EXPECT_EQ(out.errors.rfind("tessera: " + file + ":", 0), 0U) << out.errors;
  }
}

TEST(CommandLine, a_server_that_does_not_answer_is_code_3) {
  const Outcome out = outcome_of({"--server", "http://127.0.0.1:1", "jobs"});
  EXPECT_EQ(out.code, 3);
  EXPECT_EQ(out.errors.rfind("tessera: ", 0), 0U);
}

TEST(CommandLine, the_version_is_said) {
  const Outcome out = outcome_of({"--version"});
  EXPECT_EQ(out.code, 0);
  EXPECT_EQ(out.output.rfind("tessera ", 0), 0U);
}

}  // namespace
}  // namespace tessera::client
