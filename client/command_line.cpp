#include "client/command_line.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "client/describe.hpp"
#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

int usage_error(const CLI::App& app, const CLI::ParseError& error, int argc,
                const char* const* argv) {
  std::string message = error.what();
  std::vector<std::string_view> names;
  for (const CLI::App* command : app.get_subcommands({})) names.emplace_back(command->get_name());
  // A word in the command's place that is none deserves better than the parser's sentence.
  if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
    message = unknown_name("command", argv[1], names);
  fmt::print(stderr,
             "tessera: {}\n(tessera --help, and tessera COMMAND --help, say what there is)\n",
             message);
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
