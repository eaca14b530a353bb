#pragma once

namespace tessera::client {

/// Thrown where a signal asked the program to stop; main makes exit code 130 of it.
struct Interrupted {};

/// From now on SIGINT, SIGTERM and SIGHUP are noted instead of ending the program. A second one
/// ends it.
void catch_interrupts();
[[nodiscard]] bool interrupted();
void throw_if_interrupted();

}  // namespace tessera::client
