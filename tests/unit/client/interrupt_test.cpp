#include "client/interrupt.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

namespace tessera::client {
namespace {

/// The exit code of `action` in a process of its own, 128 + the signal that ended it.
int code_of(const std::function<void()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    catch_interrupts();
    action();
    _exit(0);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(Interrupt, ends_the_program_at_once_while_there_is_nothing_to_clear_away) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    EXPECT_EQ(code_of([signal] { std::raise(signal); }), 130);
  EXPECT_EQ(code_of([] {
              { const NotedInterrupts noted; }
              std::raise(SIGINT);
            }),
            130);
}

TEST(Interrupt, is_noted_while_there_is) {
  EXPECT_EQ(code_of([] {
              const NotedInterrupts noted;
              std::raise(SIGINT);
              std::raise(SIGINT);  // the same one: a tool that signals process and group
              int code = interrupted() && interrupt_noted() ? 3 : 4;
              try {
                throw_if_interrupted();
              } catch (const Interrupted&) {
                code += 10;
              }
              _exit(code);
            }),
            13);
}

TEST(Interrupt, does_not_break_off_what_is_done_because_of_it) {
  EXPECT_EQ(code_of([] {
              const NotedInterrupts noted;
              std::raise(SIGINT);
              int code = 0;
              {
                const Uninterrupted ending;
                if (!interrupted() && interrupt_noted()) code = 5;
              }
              _exit(interrupted() ? code : 6);
            }),
            5);
}

TEST(Interrupt, a_further_one_after_a_second_ends_the_program) {
  EXPECT_EQ(code_of([] {
              const NotedInterrupts noted;
              std::raise(SIGINT);
              usleep(1'100'000);
              std::raise(SIGINT);
            }),
            128 + SIGINT);
}

}  // namespace
}  // namespace tessera::client
