// What cannot be read, for now or for good: told apart, and the cost of the jobs that need it
// alone.
#include <gmock/gmock.h>

#include "server/store/damaged.hpp"
#include "tests/unit/store/store_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

TEST_F(StoreTest, ASegmentOrCheckpointThatCannotBeOpenedCostsItsJobAloneAndTheOpenNamesIt) {
  JobId journal_hurt = 0, film_hurt = 0, whole_job = 0;
  ResultPlace place;
  Checkpoint made;
  {
    const auto store = open();
    journal_hurt = store->put_job(job_record());
    film_hurt = store->put_job(job_record());
    whole_job = store->put_job(job_record());
    place = append(*store, journal_hurt, {1, 0, 0});
    const auto writer = store->begin_checkpoint(film_hurt, 1);
    writer->append(0, 1, bytes_of({1, 0, 0}, 50));
    made = writer->finish();
    store->put_checkpoint(made);
  }
  append(*open(), whole_job, {1, 0, 0});  // in a segment of its own
  const std::filesystem::path files[] = {segments().at(0),
                                         folder_ / "checkpoints" / "00000001.checkpoint"};
  const auto aside = [](const std::filesystem::path& file) { return file.string() + ".aside"; };
  for (const auto& file : files) {
    std::filesystem::rename(file, aside(file));
    std::filesystem::create_symlink(file, file);  // opening it fails, whoever asks
  }
  {
    const auto store = open();
    ASSERT_EQ(store->damage().size(), 2U);
    EXPECT_THAT(store->damage().at(journal_hurt), HasSubstr(files[0].string()));
    EXPECT_THAT(store->damage().at(film_hurt), HasSubstr(files[1].string()));
    expect_readable(*store, whole_job, 1);
    append(*store, whole_job, {1, 1, 0});
    for (const Error& error :
         {error_of([&] { static_cast<void>(store->read_result(place)); }), error_of([&] {
            static_cast<void>(
                store->read_checkpoint({made.number, made.tiles[0].offset, made.tiles[0].length}));
          })})
      EXPECT_THAT(error.what(), HasSubstr("opened"));
  }
  for (const auto& file : files) std::filesystem::rename(aside(file), file);
  const auto store = open();
  EXPECT_TRUE(store->damage().empty());
  expect_readable(*store, journal_hurt, 1);
  EXPECT_EQ(store->checkpoint_of(film_hurt, 1), made);
}

/// Told apart by its type: an error of reading may be over when it is read again.
template <class Read>
bool says_damaged(const Read& read) {
  try {
    read();
  } catch (const DamagedError&) {
    return true;
  } catch (const Error&) {
  }
  return false;
}

TEST_F(StoreTest, WhatIsReadAndIsWrongIsDamagedAndWhatCannotBeReadIsNot) {
  const auto store = open();
  const JobId job = store->put_job(job_record());
  const ResultPlace place = append(*store, job, {1, 0, 0});
  const auto writer = store->begin_checkpoint(job, 2);
  writer->append(0, 1, bytes_of({2, 0, 0}, 50));
  const Checkpoint made = writer->finish();
  const std::pair<std::filesystem::path, std::function<void()>> cases[] = {
      {segments().at(0), [&] { static_cast<void>(store->read_result(place)); }},
      {folder_ / "checkpoints" / "00000001.checkpoint", [&] {
         static_cast<void>(
             store->read_checkpoint({made.number, made.tiles[0].offset, made.tiles[0].length}));
       }}};
  for (const auto& [file, read] : cases) {
    const std::string whole = contents(file);
    EXPECT_FALSE(says_damaged(read));
    overwrite(file, whole.substr(0, whole.size() - 1).append("?"));
    const bool padded = file == segments().at(0);  // its last block has more than the record
    EXPECT_EQ(says_damaged(read), !padded);
    overwrite(file, whole.substr(0, 16).append(whole.size() - 16, '?'));
    EXPECT_TRUE(says_damaged(read)) << "other bytes";
    overwrite(file, whole.substr(0, 40));
    EXPECT_TRUE(says_damaged(read)) << "cut off";
    std::filesystem::remove(file);
    EXPECT_FALSE(says_damaged(read)) << "not there";
    std::filesystem::create_symlink(file, file);
    EXPECT_FALSE(says_damaged(read)) << "not to be opened";
    std::filesystem::remove(file);
    overwrite(file, whole);
    EXPECT_NO_THROW(read());
  }
}

}  // namespace
}  // namespace tessera::server
