#include "server/coordinator/storage_policy.hpp"

#include <gmock/gmock.h>

namespace tessera::server {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

StorageUse use(std::uint64_t kept, std::uint64_t most, std::uint64_t free) {
  StorageUse out;
  out.journal = kept / 4;
  out.checkpoints = kept / 4;
  out.blobs = kept / 4;
  out.pictures = kept / 4;
  out.films = 1 << 30;  // memory, and no disk
  out.disk_most = most;
  out.disk_free = free;
  return out;
}

TEST(Room, there_is_some_below_the_limit_and_above_the_reserve) {
  EXPECT_THAT(refusal_of(use(96, 100, 50), 50), IsEmpty());
  EXPECT_THAT(refusal_of(use(1000, 0, 50), 50), IsEmpty()) << "no limit";
}

TEST(Room, an_upload_may_take_what_is_below_the_limit_and_above_the_reserve_and_no_more) {
  EXPECT_THAT(refusal_of(use(88, 100, 62), 50, 12), IsEmpty());
  EXPECT_THAT(refusal_of(use(88, 100, 100), 50, 13), HasSubstr("--disk-limit"));
  EXPECT_THAT(refusal_of(use(0, 100, 60), 50, 11), HasSubstr("11 bytes more are too many"));
}

TEST(Room, refusals_say_the_numbers_and_what_can_be_done) {
  const std::string limit = refusal_of(use(4096, 4096, 1 << 20), 50);
  EXPECT_THAT(limit, HasSubstr("keeps 4.00 KiB and may keep 4.00 KiB"));
  EXPECT_THAT(limit, HasSubstr("--disk-limit"));
  const std::string full = refusal_of(use(0, 100, 49), 50);
  EXPECT_THAT(full, HasSubstr("49 bytes left"));
  EXPECT_THAT(full, HasSubstr("last 50 bytes"));
}

TEST(Room, a_small_file_system_keeps_a_twentieth_back) {
  EXPECT_EQ(reserve_of(1000, 1 << 30), 50U);
  EXPECT_EQ(reserve_of(std::uint64_t{1} << 40, 1 << 30), std::uint64_t{1} << 30);
}

TEST(Room, sizes_are_said_as_people_read_them) {
  EXPECT_EQ(bytes_text(1023), "1023 bytes");
  EXPECT_EQ(bytes_text(1536), "1.50 KiB");
  EXPECT_EQ(bytes_text(std::uint64_t{3} << 40), "3.00 TiB");
}

TEST(KeptJobs, are_forgotten_when_their_time_is_over_and_never_before) {
  const std::optional<Duration> hour = std::chrono::hours(1);
  EXPECT_FALSE(has_expired(1000, 1000 + 3'599'999, hour));
  EXPECT_TRUE(has_expired(1000, 1000 + 3'600'000, hour));
  EXPECT_FALSE(has_expired(0, 10'000'000, hour)) << "it has not ended";
  EXPECT_FALSE(has_expired(1000, INT64_MAX, std::nullopt)) << "kept for good";
  EXPECT_TRUE(has_expired(1000, 1000, std::optional<Duration>(Duration::zero())));
}

}  // namespace
}  // namespace tessera::server
