#include "server/coordinator/picture_cache.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <deque>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"

namespace tessera::server {
namespace {

/// Makes are gathered and finished by hand.
class PictureCacheTest : public testing::Test {
 protected:
  struct Answer {
    bool ended = false;
    Picture picture;
    std::string error;
  };

  std::shared_ptr<Answer> ask(const PictureKey& asked, std::uint64_t at_least) {
    auto answer = std::make_shared<Answer>();
    boost::asio::co_spawn(
        io,
        cache.get(asked, at_least,
                  [this](PictureCache::Done done) { makes.push_back(std::move(done)); }),
        [answer](const std::exception_ptr& error, Picture picture) {
          answer->ended = true;
          answer->picture = std::move(picture);
          try {
            if (error) std::rethrow_exception(error);
          } catch (const Error& thrown) {
            answer->error = thrown.what();
          }
        });
    poll();
    return answer;
  }
  void poll() {
    io.restart();
    io.poll();
  }
  void finish(std::uint64_t version, std::size_t size = 10) {
    const auto done = makes.front();
    makes.pop_front();
    done(nullptr, {version, std::make_shared<const std::vector<std::byte>>(size)});
    poll();
  }

  boost::asio::io_context io;
  PictureCache cache{io.get_executor(), 100};
  std::deque<PictureCache::Done> makes;
  PictureKey key{PictureKey::Form::png, 1, 1, 0, 0};
};

TEST_F(PictureCacheTest, AllWhoAskForAVersionShareOneMaking) {
  const auto one = ask(key, 5);
  const auto two = ask(key, 5);
  EXPECT_EQ(makes.size(), 1U);
  finish(5);
  const auto three = ask(key, 5);
  EXPECT_EQ(makes.size(), 0U);
  ASSERT_TRUE(one->ended && two->ended && three->ended);
  EXPECT_EQ(one->picture.bytes, two->picture.bytes);
  EXPECT_EQ(one->picture.bytes, three->picture.bytes);
}

TEST_F(PictureCacheTest, NewerVersionWaitsForTheOneUnderWayAndIsThenMadeOnce) {
  const auto old = ask(key, 5);
  const auto newer = ask(key, 6);
  const auto newest = ask(key, 7);
  EXPECT_EQ(makes.size(), 1U);
  finish(5);
  EXPECT_TRUE(old->ended);
  EXPECT_FALSE(newer->ended);
  EXPECT_EQ(makes.size(), 1U);
  finish(7);
  EXPECT_TRUE(newer->ended && newest->ended);
  EXPECT_EQ(newer->picture.version, 7U);
  EXPECT_EQ(newer->picture.bytes, newest->picture.bytes);
  EXPECT_TRUE(makes.empty());
}

TEST_F(PictureCacheTest, ErrorReachesAllWhoWaitAndTheNextOneTriesAgain) {
  const auto one = ask(key, 1);
  const auto two = ask(key, 0);
  makes.front()(std::make_exception_ptr(Error(ErrorKind::failed, "broken")), {});
  makes.pop_front();
  poll();
  EXPECT_EQ(one->error, "broken");
  EXPECT_EQ(two->error, "broken");
  const auto again = ask(key, 1);
  finish(1);
  EXPECT_EQ(again->error, "");
  EXPECT_EQ(again->picture.version, 1U);
}

TEST_F(PictureCacheTest, KeepsThoseAskedForLastWithinItsBytes) {
  PictureKey keys[3] = {key, key, key};
  for (int i = 0; i < 3; ++i) {
    keys[i].frame = i;
    ask(keys[i], 1);
    finish(1, 40);
  }
  EXPECT_EQ(cache.bytes(), 80U);
  ask(keys[2], 1);
  EXPECT_TRUE(makes.empty());
  ask(keys[0], 1);
  EXPECT_EQ(makes.size(), 1U) << "the oldest is gone";
}

TEST_F(PictureCacheTest, ForgottenJobIsMadeAnew) {
  ask(key, 1);
  finish(1);
  cache.forget(1);
  EXPECT_EQ(cache.bytes(), 0U);
  ask(key, 1);
  EXPECT_EQ(makes.size(), 1U);
}

TEST(FrameFile, AFinishedPictureThatIsThereNoMoreIsAFailureWithItsPlace) {
  try {
    require_kept("data/jobs/1/frame-0001.exr");
    FAIL() << "it is not there";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::failed);
    EXPECT_EQ(error.place().file, "data/jobs/1/frame-0001.exr");
  }
}

}  // namespace
}  // namespace tessera::server
