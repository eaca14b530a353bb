#include "server/coordinator/quarantine_table.hpp"

#include <gmock/gmock.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>

#include "common/base/error.hpp"

namespace tessera::server {
namespace {

using boost::asio::awaitable;
using testing::ElementsAre;
using testing::IsEmpty;

/// A store that takes its time, and refuses what it is told to.
class QuarantineTableTest : public testing::Test {
 protected:
  boost::asio::io_context io{1};
  Crew crew{io.get_executor()};
  Signal changed{io.get_executor()};
  bool refuses = false;
  std::vector<std::string> stored;  ///< "name: reason", "name: none"
  std::vector<std::string> told;    ///< of what is in force: "+name", "-name"
  QuarantineTable table{crew, changed, hooks()};

  QuarantineTable::Hooks hooks() {
    QuarantineTable::Hooks hooks;
    hooks.save = [this](std::string name, std::optional<Quarantine> kept) {
      return save(std::move(name), std::move(kept));
    };
    hooks.imposed = [this](const Quarantine& one) { told.push_back("+" + one.name); };
    hooks.lifted = [this](const std::string& name) { told.push_back("-" + name); };
    return hooks;
  }
  awaitable<void> save(std::string name, std::optional<Quarantine> kept) {
    const bool fails = refuses;
    co_await crew.pause(std::chrono::milliseconds(20));
    if (fails) throw Error(ErrorKind::no_room, "the disk is full");
    stored.push_back(name + ": " + (kept ? kept->reason : "none"));
  }
  static Quarantine of(const std::string& name, const std::string& reason, const char* by) {
    Quarantine one;
    one.name = name;
    one.reason = reason;
    one.by = by;
    return one;
  }
  /// What went wrong with it, once it has ended: "" if nothing.
  std::shared_ptr<std::optional<std::string>> ask(awaitable<void> request) {
    auto answer = std::make_shared<std::optional<std::string>>();
    boost::asio::co_spawn(io, std::move(request), [answer](const std::exception_ptr& error) {
      try {
        if (error) std::rethrow_exception(error);
        *answer = "";
      } catch (const std::exception& known) {
        *answer = known.what();
      }
    });
    return answer;
  }
  void run() {
    io.restart();
    io.run();
  }
  [[nodiscard]] std::vector<std::string> reasons() const {
    std::vector<std::string> all;
    for (const Quarantine& one : table.all())
      all.push_back(one.reason + (one.durable ? "" : " (not durable)"));
    return all;
  }
};

TEST_F(QuarantineTableTest, NothingThatAPersonSaysIsInForceBeforeItIsStored) {
  const auto answer = ask(table.impose(of("w", "fan", "user")));
  io.poll();
  EXPECT_THAT(reasons(), IsEmpty());
  EXPECT_THAT(told, IsEmpty());
  run();
  EXPECT_EQ(*answer, "");
  EXPECT_THAT(reasons(), ElementsAre("fan"));
  EXPECT_THAT(told, ElementsAre("+w"));
  EXPECT_THAT(stored, ElementsAre("w: fan"));
}

TEST_F(QuarantineTableTest, WhatTheDiskRefusesIsNotInForceAndTheStoreIsMadeToSaySo) {
  refuses = true;
  const auto answer = ask(table.impose(of("w", "fan", "user")));
  while (!*answer) io.run_one();
  EXPECT_EQ(*answer, "the disk is full");
  EXPECT_THAT(reasons(), IsEmpty());
  EXPECT_THAT(told, IsEmpty());
  refuses = false;
  run();
  EXPECT_THAT(stored, ElementsAre("w: none")) << "a commit that failed may be there all the same";
}

TEST_F(QuarantineTableTest, WhatTheServerFindsWhileAPersonsIsRefusedStaysInForceAndIsKept) {
  refuses = true;
  const auto answer = ask(table.impose(of("w", "fan", "user")));
  io.poll();
  table.found(of("w", "fails", "server"));
  while (!*answer) io.run_one();
  EXPECT_EQ(*answer, "the disk is full");
  EXPECT_THAT(reasons(), ElementsAre("fails (not durable)"));
  refuses = false;
  run();
  EXPECT_THAT(reasons(), ElementsAre("fails"));
  EXPECT_THAT(stored, ElementsAre("w: fails"));
}

TEST_F(QuarantineTableTest, ReleaseThatTheDiskRefusesChangesNothing) {
  table.restore(of("w", "fan", "user"));
  refuses = true;
  const auto answer = ask(table.lift("w"));
  while (!*answer) io.run_one();
  EXPECT_EQ(*answer, "the disk is full");
  EXPECT_THAT(reasons(), ElementsAre("fan"));
  EXPECT_THAT(told, IsEmpty());
  refuses = false;
  run();
  EXPECT_THAT(stored, ElementsAre("w: fan"));
}

TEST_F(QuarantineTableTest, ChangesOfOneNameComeOneAfterAnotherAndTheLastCounts) {
  const auto first = ask(table.impose(of("w", "fan", "user")));
  const auto second = ask(table.lift("w"));
  const auto third = ask(table.impose(of("w", "disk", "user")));
  run();
  for (const auto& answer : {first, second, third}) EXPECT_EQ(*answer, "");
  EXPECT_THAT(stored, ElementsAre("w: fan", "w: none", "w: disk"));
  EXPECT_THAT(told, ElementsAre("+w", "-w", "+w"));
  EXPECT_THAT(reasons(), ElementsAre("disk"));
}

}  // namespace
}  // namespace tessera::server
