#include "common/base/open_files.hpp"

#include <sys/resource.h>

namespace tessera {

std::uint64_t raise_open_files_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return UINT64_MAX;
  const rlimit raised{limit.rlim_max, limit.rlim_max};
  const rlim_t holds = setrlimit(RLIMIT_NOFILE, &raised) == 0 ? raised.rlim_cur : limit.rlim_cur;
  return holds == RLIM_INFINITY ? UINT64_MAX : holds;
}

}  // namespace tessera
