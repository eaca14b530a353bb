#include "client/interrupt.hpp"

#include <time.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <initializer_list>

namespace tessera::client {

namespace {
constexpr std::int64_t together = 1'000'000'000;  // ns

std::atomic<std::int64_t> first{0};
volatile std::sig_atomic_t noted = 0;
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

void note(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t at = now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
  if (noted == 0) {
    first = at;
    noted = 1;
  } else if (at - first > together) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);  // comes when this handler returns
  }
}
}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

bool interrupted() { return noted != 0; }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

}  // namespace tessera::client
