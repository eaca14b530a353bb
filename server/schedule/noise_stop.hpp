#pragma once
#include <cstdint>

#include "common/job/pass_plan.hpp"

/// At which passes of a frame its noise is looked at, and where one ended. Pure.
namespace tessera::server {

/// After so many passes, but for the last: at 16 samples, and then each time that there are an
/// eighth more than at the last look.
bool noise_is_looked_at(const PassPlan& plan, std::uint32_t passes);
/// The first look after so many passes or more; all passes if there is none.
std::uint32_t next_look(const PassPlan& plan, std::uint32_t passes);
/// How many passes end at or before so many samples. O(log passes).
std::uint32_t passes_within(const PassPlan& plan, std::int64_t samples);

}  // namespace tessera::server
