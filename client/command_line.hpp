#pragma once

namespace tessera::client {

/// Reads the command line, runs the command, says what went wrong on standard error as "tessera:
/// …", and gives the exit code: 0 done, 1 failed, 2 wrong usage or bad input, 3 server not reached,
/// 4 refused, 130 interrupted.
int run(int argc, const char* const* argv);

}  // namespace tessera::client
