// What stands behind the method in a request's first line.
#include <algorithm>

#include "server/http/query.hpp"
#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse([&] {
    const server::Target target = server::parse_target(fuzz::text_of(data, size));
    const std::string path = target.path();
    fuzz::require(
        std::all_of(path.begin(), path.end(), [](unsigned char c) { return c >= 32 && c != 127; }),
        "a path has no control characters");
    for (const auto& [name, value] : target.query)
      fuzz::require(target.parameter(name) == value, "a parameter stands once");
  });
  return 0;
}
