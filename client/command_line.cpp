#include "client/command_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "client/describe.hpp"
#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

/// The words of the command line up to a bare "--", behind which nothing is a flag.
std::vector<std::string> words_of(int argc, const char* const* argv) {
  std::vector<std::string> out;
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) out.emplace_back(argv[i]);
  return out;
}

std::vector<std::string> flags_of(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  return out;
}

/// A sentence for a flag or command that there is none of, with the nearest that there is; empty if
/// something else is wrong.
std::string unknown_word(const CLI::App& app, const std::vector<std::string>& words) {
  const auto shown = [](std::string_view kind, std::string_view name,
                        const std::vector<std::string>& known) {
    return unknown_name(kind, name, {known.begin(), known.end()});
  };
  std::vector<std::string> flags = flags_of(app);
  const auto chosen = app.get_subcommands();
  for (const CLI::App* command : chosen)
    for (std::string& flag : flags_of(*command))
      if (flag != "--help") flags.push_back(std::move(flag));
  bool is_value = false;
  for (const std::string& word : words) {
    const bool of_flag = std::exchange(is_value, false);
    if (word.starts_with("--")) {
      const std::string name = word.substr(0, word.find('='));
      if (std::find(flags.begin(), flags.end(), name) == flags.end())
        return shown("flag", name, flags);
      // Of what may stand before a command, these have a value.
      is_value = word == "--server" || word == "--token";
    } else if (chosen.empty() && !of_flag && !word.starts_with("-")) {
      std::vector<std::string> names;
      for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
      return shown("command", word, names);
    }
  }
  return {};
}

int usage_error(const CLI::App& app, const CLI::ParseError& error, int argc,
                const char* const* argv) {
  const std::string unknown = unknown_word(app, words_of(argc, argv));
  fmt::print(stderr,
             "tessera: {}\n(tessera --help, and tessera COMMAND --help, say what there is)\n",
             unknown.empty() ? error.what() : unknown);
  return exit_code(ErrorKind::bad_input);
}

int carry_out(const Line& line) {
  try {
    const Settings settings =
        settle(line.flags, environment_settings(), config_settings(config_file()), line.json);
    catch_interrupts();
    return line.command(settings);
  } catch (const Interrupted&) {
    fmt::print(stderr, "tessera: interrupted\n");
    return 130;
  } catch (const Error& error) {
    fmt::print(stderr, "tessera: {}\n", error.what());
    return exit_code(error.kind());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "tessera: not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "tessera: {}\n", error.what());
  }
  return exit_code(ErrorKind::failed);
}

}  // namespace

int run(int argc, const char* const* argv) {
  CLI::App app{"Tessera: one frame over many workers", "tessera"};
  Line line;
  describe(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error, argc, argv);
  }
  return carry_out(line);
}

}  // namespace tessera::client
