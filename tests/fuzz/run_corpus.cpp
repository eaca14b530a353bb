// Calls a fuzz target where there is no libFuzzer: with every file of its corpus, then with changed
// ones. Its flags are libFuzzer's own:
//   TARGET [-runs=N] [-seed=S] [-rss_limit_mb=M] FILE|FOLDER…
// What makes a target end badly is left as crash-input in the present folder. Memory beyond the
// limit is refused by the system, and no target takes a std::bad_alloc for an answer.
#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/mutate.hpp"
#include "tests/fuzz/target.hpp"

namespace {

namespace fs = std::filesystem;
using tessera::fuzz::Mutator;

constexpr std::size_t input_most = 4096;

struct Options {
  std::uint64_t runs = 1000, seed = 1, limit_mb = 2048;
  std::vector<std::string> inputs;
};

std::uint64_t number_of(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size())
    throw std::invalid_argument("expected a whole number, found " + std::string(text));
  return value;
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  return {std::istreambuf_iterator<char>(in), {}};
}

void add_inputs(const fs::path& path, std::vector<std::string>& inputs) {
  if (!fs::is_directory(path)) {
    inputs.push_back(content_of(path));
    return;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(path)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) inputs.push_back(content_of(file));
}

Options options_from(int count, char** arguments) {
  Options out;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    const std::size_t equals = argument.find('=');
    const std::string_view key = argument.substr(0, equals);
    if (!argument.starts_with('-'))
      add_inputs(argument, out.inputs);
    else if (key == "-runs")
      out.runs = number_of(argument.substr(equals + 1));
    else if (key == "-seed")
      out.seed = number_of(argument.substr(equals + 1));
    else if (key == "-rss_limit_mb")
      out.limit_mb = number_of(argument.substr(equals + 1));
    else
      throw std::invalid_argument("unknown flag " + std::string(argument) +
                                  " (expected -runs, -seed or -rss_limit_mb)");
  }
  if (out.inputs.empty()) throw std::invalid_argument("expected a corpus: files or folders");
  return out;
}

/// AddressSanitizer's shadow is terabytes of addresses: it has limits of its own.
void limit_memory([[maybe_unused]] std::uint64_t megabytes) {
#ifndef __SANITIZE_ADDRESS__
  const rlim_t bytes = megabytes << 20;
  const rlimit limit{bytes, bytes};
  if (setrlimit(RLIMIT_AS, &limit) != 0) throw std::runtime_error("memory cannot be limited");
#endif
}

/// What the target is looking at.
std::vector<std::uint8_t> present;

void keep_present() {
  if (std::FILE* file = std::fopen("crash-input", "wb")) {
    std::fwrite(present.data(), 1, present.size(), file);
    std::fclose(file);
    std::fprintf(stderr, "the input is kept as crash-input\n");
  }
}

void on_signal(int number) {
  keep_present();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

/// Any exception that the target lets through ends the process.
void run(const std::string& input) noexcept {
  // A buffer of just its length, so that tools see each byte beyond it.
  std::vector<std::uint8_t>(input.begin(), input.end()).swap(present);
  LLVMFuzzerTestOneInput(present.data(), present.size());
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const Options options = options_from(count, arguments);
    limit_memory(options.limit_mb);
    for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
      std::signal(number, on_signal);
    for (const std::string& input : options.inputs) run(input);
    Mutator mutator(options.seed);
    for (std::uint64_t i = options.inputs.size(); i < options.runs; ++i) {
      const std::string& other = options.inputs[mutator.below(options.inputs.size())];
      run(mutator.mutant(options.inputs[i % options.inputs.size()], other, input_most));
    }
    std::printf(
        "%zu inputs, %zu of them as they stand in the corpus\n",
        static_cast<std::size_t>(std::max<std::uint64_t>(options.runs, options.inputs.size())),
        options.inputs.size());
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: %s\n", arguments[0], problem.what());
    return 2;
  }
}
