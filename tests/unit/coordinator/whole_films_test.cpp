#include "server/coordinator/whole_films.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>

namespace tessera::server {
namespace {

class WholeFilmsTest : public testing::Test {
 protected:
  boost::asio::io_context io{1};
  Signal changed{io.get_executor()};
};

TEST_F(WholeFilmsTest, AsManyAreHeldAsFitAndTheNextOnceOneIsLetGo) {
  WholeFilms films(100, changed);
  WholeFilms::Share first = films.take(40);
  const WholeFilms::Share second = films.take(40);
  EXPECT_TRUE(first && second);
  EXPECT_FALSE(films.take(40));
  EXPECT_EQ(films.used(), 80U);
  const WholeFilms::Share small = films.take(20);
  EXPECT_TRUE(small);
  WholeFilms::Share copy = first;
  first.reset();
  EXPECT_FALSE(films.take(40)) << "somebody holds it still";
  copy.reset();
  EXPECT_TRUE(films.take(40));
}

TEST_F(WholeFilmsTest, OneThatIsLargerThanAllOfThemIsHeldAlone) {
  WholeFilms films(100, changed);
  WholeFilms::Share large = films.take(1000);
  EXPECT_TRUE(large);
  EXPECT_FALSE(films.take(1));
  large.reset();
  EXPECT_TRUE(films.take(1));
}

TEST_F(WholeFilmsTest, ShareMayOutliveTheFilms) {
  WholeFilms::Share share;
  {
    WholeFilms films(100, changed);
    share = films.take(10);
  }
  share.reset();
}

}  // namespace
}  // namespace tessera::server
