#pragma once
#include <cstdio>
#include <string>

namespace tessera::farm_test {

/// One figure a line, beside what it should reach.
inline void print(const std::string& what, double value, const std::string& unit,
                  const std::string& aim) {
  std::printf("%-64s %12.4g %-10s %s\n", what.c_str(), value, unit.c_str(), aim.c_str());
  std::fflush(stdout);
}

}  // namespace tessera::farm_test
