#include "client/change_worker.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/base/error.hpp"

namespace tessera::client {
namespace {

using testing::HasSubstr;

Json answer() {
  return {{"workers",
           {{{"id", 1}, {"name", "render-1"}},
            {{"id", 2}, {"name", "desk"}},
            {{"id", 3}, {"name", "desk"}},
            {{"id", 4}, {"name", "2"}}}}};
}

std::string fault_of(const Json& workers, const std::string& text, ErrorKind kind) {
  try {
    find_worker(workers, text);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind);
    return error.what();
  }
  return "found";
}

TEST(FindWorker, takes_a_number_before_a_name) {
  EXPECT_EQ(find_worker(answer(), "render-1"), 1U);
  EXPECT_EQ(find_worker(answer(), "3"), 3U);
  EXPECT_EQ(find_worker(answer(), "2"), 2U);
}

TEST(FindWorker, says_the_numbers_of_workers_that_share_a_name) {
  EXPECT_THAT(fault_of(answer(), "desk", ErrorKind::conflict), HasSubstr("one of 2, 3"));
}

TEST(FindWorker, says_the_nearest_name_for_one_that_is_not_there) {
  EXPECT_THAT(fault_of(answer(), "rander-1", ErrorKind::not_found), HasSubstr("\"render-1\""));
  EXPECT_THAT(fault_of(Json{{"workers", Json::array()}}, "x", ErrorKind::not_found),
              HasSubstr("none is connected"));
}

TEST(NameOfWorker, is_a_connected_ones_by_number_or_name_or_a_quarantined_ones) {
  Json all = answer();
  all["quarantines"] = Json::array({{{"name", "away-7"}}});
  for (const Absent absent : {Absent::quarantined, Absent::any}) {
    EXPECT_EQ(name_of_worker(all, "3", absent).name, "desk");
    EXPECT_EQ(name_of_worker(all, "desk", absent).name, "desk") << "all of a name are meant";
    EXPECT_EQ(name_of_worker(all, "away-7", absent).name, "away-7");
    EXPECT_EQ(name_of_worker(all, "away-7", absent).note, "");
  }
  const auto fault = [&](const char* text, Absent absent) {
    try {
      return name_of_worker(all, text, absent).name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::not_found);
      return std::string(error.what());
    }
  };
  EXPECT_THAT(fault("away-8", Absent::quarantined), HasSubstr("did you mean \"away-7\""));
  EXPECT_THAT(fault("17", Absent::any), HasSubstr("unknown worker")) << "no name, but a number";
}

TEST(NameOfWorker, is_any_where_it_need_not_be_connected_and_a_note_says_that_it_is_not) {
  Json all = answer();
  all["quarantines"] = Json::array();
  const NamedWorker meant = name_of_worker(all, "render-2", Absent::any);
  EXPECT_EQ(meant.name, "render-2");
  EXPECT_THAT(meant.note, HasSubstr("did you mean \"render-1\""));
  EXPECT_THAT(meant.note, HasSubstr("whoever comes under this name"));
}

}  // namespace
}  // namespace tessera::client
