#pragma once
#include <immintrin.h>

namespace tessera::render {

/// Numbers too small to be normal count as 0 while this lives (flush to zero, denormals are zero):
/// they cost hundreds of cycles, and all machines must treat them alike. What was set before is set
/// again at the end.
///
/// It stands around each piece of work, not in a scheduler's observer: TBB does not tell an
/// observer that goes away about threads that are still inside, and those would keep the mode.
class FlushDenormals {
 public:
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

}  // namespace tessera::render
