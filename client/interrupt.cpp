#include "client/interrupt.hpp"

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <initializer_list>
#include <string_view>

namespace tessera::client {

namespace {
constexpr std::int64_t together = 1'000'000'000;  // ns

std::atomic<std::int64_t> first{0};
std::atomic<bool> noted{false};
std::atomic<int> noting{0};  // NotedInterrupts alive
std::atomic<int> whole{0};   // Uninterrupted alive
static_assert(std::atomic<std::int64_t>::is_always_lock_free &&
              std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

void note(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t at = now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
  if (!noted && noting == 0) {
    constexpr std::string_view words = "tessera: interrupted\n";
    [[maybe_unused]] const ssize_t written = write(2, words.data(), words.size());
    _exit(130);
  }
  if (!noted) {
    first = at;
    noted = true;
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

NotedInterrupts::NotedInterrupts() { ++noting; }
NotedInterrupts::~NotedInterrupts() { --noting; }

Uninterrupted::Uninterrupted() { ++whole; }
Uninterrupted::~Uninterrupted() { --whole; }

bool interrupt_noted() { return noted; }

bool interrupted() { return noted && whole == 0; }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

}  // namespace tessera::client
