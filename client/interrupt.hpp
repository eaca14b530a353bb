#pragma once

namespace tessera::client {

/// Thrown where a signal asked the program to stop; main makes exit code 130 of it.
struct Interrupted {};

/// From now on SIGINT, SIGTERM and SIGHUP are noted instead of ending the program. One that
/// comes more than a second later ends it; earlier ones are the same one (some tools signal both a
/// process and its group), and the farm's folder is still being cleared away.
void catch_interrupts();
[[nodiscard]] bool interrupted();
void throw_if_interrupted();

}  // namespace tessera::client
