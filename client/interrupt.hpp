#pragma once

namespace tessera::client {

/// Thrown where a signal asked the program to stop; main makes exit code 130 of it.
struct Interrupted {};

/// From now on SIGINT, SIGTERM and SIGHUP say "interrupted" and end the program with exit code 130,
/// at once; while a NotedInterrupts lives they are noted instead.
void catch_interrupts();

/// While one lives there is something to clear away, and whoever owns it looks whether a signal was
/// noted. A further signal that comes more than a second later ends the program; earlier ones are
/// the same one (some tools signal both a process and its group).
class NotedInterrupts {
 public:
  NotedInterrupts();
  ~NotedInterrupts();
  NotedInterrupts(const NotedInterrupts&) = delete;
  NotedInterrupts& operator=(const NotedInterrupts&) = delete;
};

/// Whether a signal was noted, and no Uninterrupted lives.
[[nodiscard]] bool interrupted();
void throw_if_interrupted();
/// Whether a signal was noted at all.
[[nodiscard]] bool interrupt_noted();

/// While one lives, a signal that was noted breaks nothing off: what is under way is done because
/// of it, or would leave something behind if it were half done.
class Uninterrupted {
 public:
  Uninterrupted();
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;
};

}  // namespace tessera::client
