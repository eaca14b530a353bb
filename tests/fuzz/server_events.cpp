// A stream of server-sent events, whole and byte by byte.
#include "common/net/http_client.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

void add(std::vector<net::ServerEvent> more, std::vector<net::ServerEvent>& events) {
  std::move(more.begin(), more.end(), std::back_inserter(events));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::take_or_refuse([&] {
    const std::string_view text = fuzz::text_of(data, size);
    std::vector<net::ServerEvent> whole, pieces;
    net::EventParser at_once, by_byte;
    add(at_once.feed(text), whole);
    for (std::size_t i = 0; i < text.size(); ++i) add(by_byte.feed(text.substr(i, 1)), pieces);
    const auto same = [](const net::ServerEvent& a, const net::ServerEvent& b) {
      return a.id == b.id && a.type == b.type && a.data == b.data;
    };
    fuzz::require(std::equal(whole.begin(), whole.end(), pieces.begin(), pieces.end(), same),
                  "events are the same however their bytes are cut");
  });
  return 0;
}
