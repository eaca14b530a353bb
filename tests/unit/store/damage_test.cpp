// What a kill, a bad disk, a full disk and another program's files do to a data folder.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "server/store/database.hpp"
#include "tests/unit/store/store_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

TEST_F(StoreTest, ATailThatWasNeverIndexedChangesNothingWhereverItIsCut) {
  JobId job = 0;
  std::string record;
  {
    const auto store = open();
    job = store->put_job(job_record());
    append(*store, job, {1, 0, 0});
    const ResultPlace place = append(*store, job, {1, 1, 0});
    record = contents(segments().at(0)).substr(place.offset, place.length);
  }
  const auto file = segments().at(0);
  const std::string whole = contents(file);
  for (std::size_t cut = 0; cut <= record.size(); ++cut) {
    overwrite(file, whole + record.substr(0, cut));
    const auto store = open();
    expect_readable(*store, job, 2);
  }
  const auto store = open();
  append(*store, job, {1, 2, 0});
  expect_readable(*store, job, 3);
}

TEST_F(StoreTest, ASegmentThatIsCutOrGoneCostsItsJobsAloneAndTheOpenNamesIt) {
  JobId hurt = 0, whole_job = 0;
  ResultPlace place;
  {
    const auto store = open();
    hurt = store->put_job(job_record());
    whole_job = store->put_job(job_record());
    place = append(*store, hurt, {1, 0, 0});
  }
  append(*open(), whole_job, {1, 0, 0});  // in a segment of its own
  const auto file = segments().at(0);
  const std::string whole = contents(file);
  const std::uint64_t indexed = place.offset + place.length;
  const auto expect_damage = [&] {
    const auto store = open();
    ASSERT_EQ(store->damage().size(), 1U);
    EXPECT_THAT(store->damage().at(hurt), HasSubstr(file.string()));
    EXPECT_THAT(store->damage().at(hurt), HasSubstr("job " + std::to_string(hurt)));
    EXPECT_EQ(results(*store, hurt).size(), 1U) << "it stays indexed: the file may come back";
    EXPECT_EQ(error_of([&] { static_cast<void>(store->read_result(place)); }).kind(),
              ErrorKind::failed);
    expect_readable(*store, whole_job, 1);
  };
  for (const std::uint64_t left : {std::uint64_t{0}, indexed / 2, indexed - 1}) {
    overwrite(file, whole.substr(0, left));
    expect_damage();
  }
  std::filesystem::remove(file);
  expect_damage();
  overwrite(file, whole);
  const auto store = open();
  EXPECT_TRUE(store->damage().empty());
  expect_readable(*store, hurt, 1);
}

TEST_F(StoreTest, NoNewFileTakesTheNumberOfOneThatIsLacking) {
  JobId job = 0;
  ResultPlace place;
  Checkpoint made;
  {
    const auto store = open();
    job = store->put_job(job_record());
    place = append(*store, job, {1, 0, 0});
    const auto writer = store->begin_checkpoint(job, 2);
    writer->append(0, 1, bytes_of({2, 0, 0}, 50));
    made = writer->finish();
    store->put_checkpoint(made);
  }
  const auto file = segments().at(0);
  const std::string whole = contents(file);
  std::filesystem::remove(file);
  std::filesystem::remove_all(folder_ / "checkpoints");
  {
    const auto store = open();
    EXPECT_GT(append(*store, job, {1, 1, 0}).segment, place.segment);
    const auto writer = store->begin_checkpoint(job, 3);
    writer->append(0, 1, bytes_of({3, 0, 0}, 50));
    EXPECT_GT(writer->finish().number, made.number);
  }
  overwrite(file, whole);
  expect_readable(*open(), job, 2);
}

TEST_F(StoreTest, EveryFlippedBitOfARecordOrItsSegmentsHeaderIsFound) {
  const auto store = open();
  const JobId job = store->put_job(job_record());
  const ResultPlace place = append(*store, job, {1, 0, 0}, 40);
  const auto file = segments().at(0);
  const std::string whole = contents(file);
  std::fstream in_place(file, std::ios::in | std::ios::out | std::ios::binary);
  const auto put = [&](std::size_t at, int byte) {
    in_place.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte)).flush();
  };
  constexpr std::size_t header = 16;
  for (std::size_t bit = 0; bit < 8 * (place.offset + place.length); ++bit) {
    if (bit / 8 >= header && bit / 8 < place.offset) continue;  // fills the header's block
    put(bit / 8, whole[bit / 8] ^ (1 << (bit % 8)));
    const Error error = error_of([&] { static_cast<void>(store->read_result(place)); });
    EXPECT_EQ(error.kind(), ErrorKind::failed) << bit;
    EXPECT_THAT(error.what(), HasSubstr(file.string()));
    put(bit / 8, whole[bit / 8]);
  }
  expect_readable(*store, job, 1);
}

TEST_F(StoreTest, APlaceThatIsNoneIsAnErrorWithoutAllocatingWhatItSays) {
  const auto store = open();
  const JobId job = store->put_job(job_record());
  ResultPlace place = append(*store, job, {1, 0, 0});
  place.length = ~std::uint64_t{0} >> 1;
  EXPECT_EQ(error_of([&] { static_cast<void>(store->read_result(place)); }).kind(),
            ErrorKind::failed);
  place.length = 3;
  EXPECT_EQ(error_of([&] { static_cast<void>(store->read_result(place)); }).kind(),
            ErrorKind::failed);
  place.segment = 77;
  EXPECT_EQ(error_of([&] { static_cast<void>(store->read_result(place)); }).kind(),
            ErrorKind::failed);
}

TEST_F(StoreTest, ANewerSchemaIsRefusedAndLeftAsItIs) {
  open().reset();
  Database(folder_ / "tessera.db", Database::Mode::read_write).execute("PRAGMA user_version = 99");
  const Error error = error_of([&] { static_cast<void>(open()); });
  EXPECT_EQ(error.kind(), ErrorKind::conflict);
  EXPECT_THAT(error.what(), HasSubstr("newer"));
  EXPECT_THAT(error.what(), HasSubstr("99"));
  Database database(folder_ / "tessera.db", Database::Mode::read_write);
  EXPECT_EQ(database.integer("PRAGMA user_version"), 99);
  EXPECT_EQ(database.integer("SELECT value FROM meta WHERE key = 'epoch'"), 1);
}

TEST_F(StoreTest, AnotherProgramsDatabaseIsRefused) {
  std::filesystem::create_directories(folder_);
  Database(folder_ / "tessera.db", Database::Mode::read_write).execute("CREATE TABLE songs(title)");
  const Error error = error_of([&] { static_cast<void>(open()); });
  EXPECT_EQ(error.kind(), ErrorKind::conflict);
  EXPECT_THAT(error.what(), HasSubstr("another program"));
}

TEST_F(StoreTest, ADamagedDatabaseIsSaidByItsName) {
  open().reset();
  const auto file = folder_ / "tessera.db";
  std::string bytes = contents(file);
  bytes.replace(0, 64, std::string(64, 'x'));
  overwrite(file, bytes);
  const Error error = error_of([&] { static_cast<void>(open()); });
  EXPECT_EQ(error.kind(), ErrorKind::failed);
  EXPECT_THAT(error.what(), HasSubstr(file.string()));
  EXPECT_THAT(error.what(), HasSubstr("damaged"));
}

TEST_F(StoreTest, ADatabaseWhosePagesAreGarbageIsSaidByItsName) {
  {
    const auto store = open();
    const JobId job = store->put_job(job_record());
    for (std::uint32_t tile = 0; tile < 100; ++tile) append(*store, job, {1, tile, 0});
  }
  const auto file = folder_ / "tessera.db";
  const std::string whole = contents(file);
  constexpr std::size_t page = 4096;
  ASSERT_GT(whole.size(), 4 * page);
  int said = 0;
  for (std::size_t at = 0; at < whole.size(); at += page) {
    overwrite(file, std::string(whole).replace(at, page, std::string(page, 'x')));
    try {
      const auto store = open();
      for (const JobRecord& job : store->list_jobs()) results(*store, job.id);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::failed) << at;
      EXPECT_THAT(error.what(), HasSubstr(file.string())) << at;
      EXPECT_THAT(error.what(), HasSubstr("damaged")) << at;
      ++said;
    }
  }
  EXPECT_GT(said, 4);
  overwrite(file, whole);
  expect_readable(*open(), 1, 100);
}

TEST_F(StoreTest, ADamagedRecordLeavesAllOthersReadable) {
  const auto store = open();
  const JobId one = store->put_job(job_record());
  const JobId two = store->put_job(job_record());
  const ResultPlace damaged = append(*store, one, {1, 0, 0});
  append(*store, one, {1, 1, 0});
  append(*store, two, {1, 0, 0});
  std::fstream(segments().at(0), std::ios::in | std::ios::out | std::ios::binary)
      .seekp(static_cast<std::streamoff>(damaged.offset + damaged.length - 1))
      .put('?');
  const Error error = error_of([&] { static_cast<void>(store->read_result(damaged)); });
  EXPECT_THAT(error.what(), HasSubstr(segments().at(0).string()));
  EXPECT_THAT(error.what(), HasSubstr("damaged"));
  EXPECT_EQ(store->read_result(results(*store, one).at(1).place).info, info_of(one, {1, 1, 0}));
  expect_readable(*store, two, 1);
}

TEST_F(StoreTest, AFolderThatCannotBeMadeIsSaidByItsName) {
  for (const std::filesystem::path folder : {"/proc/tessera-test", "/dev/null/tessera-test"}) {
    const Error error = error_of([&] { static_cast<void>(Store::open(folder)); });
    EXPECT_EQ(error.kind(), ErrorKind::failed);
    EXPECT_THAT(error.what(), HasSubstr(folder.string()));
  }
}

/// No file may grow past the limit while this lives: what a full disk does, for any user.
class FullDisk {
 public:
  explicit FullDisk(rlim_t most) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{most, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    static_cast<void>(std::signal(SIGXFSZ, handler_));
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

/// With small records the database's log is the first to hit the limit, with large ones the
/// journal.
class FullDiskTest : public StoreTest, public ::testing::WithParamInterface<std::size_t> {};

TEST_P(FullDiskTest, AFullDiskFailsTheAppendAndLosesNothingOfWhatWasKept) {
  JobId job = 0;
  std::size_t kept = 0;
  int failed = 0;
  {
    const auto store = open();
    job = store->put_job(job_record());
    std::uint32_t tile = 0;
    for (rlim_t limit = 1000; limit < 400'000; limit += limit / 7) {
      {
        const FullDisk full(limit);
        try {
          append(*store, job, {1, tile, 0}, GetParam());
          ++kept;
        } catch (const Error& error) {
          EXPECT_THAT(error.kind(), testing::AnyOf(ErrorKind::failed, ErrorKind::no_room));
          EXPECT_THAT(error.what(), HasSubstr(folder_.string()));
          ++failed;
        }
      }
      ++tile;
      expect_readable(*store, job, kept);
      append(*store, job, {1, tile++, 0}, GetParam());  // there is room again
      ++kept;
    }
    expect_readable(*store, job, kept);
  }
  EXPECT_GT(failed, 3);
  expect_readable(*open(), job, kept);
}

INSTANTIATE_TEST_SUITE_P(Sizes, FullDiskTest, ::testing::Values(10, 30'000), [](const auto& size) {
  return size.param < 1000 ? "DatabaseFirst" : "JournalFirst";
});

}  // namespace
}  // namespace tessera::server
