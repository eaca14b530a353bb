// Frames as people write them.
#include "common/job/frames.hpp"
#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse([&] {
    const FrameList frames = frames_from_text(fuzz::text_of(data, size));
    fuzz::require(frames.count() > 0 && frames.number(frames.count() - 1) == frames.last(),
                  "a list of frames has a last one");
    fuzz::require(frames_from_text(text_of(frames)) == frames,
                  "frames are the same when they are written and read again");
  });
  return 0;
}
