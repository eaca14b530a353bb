// A disk that fails at one kind of call: what was committed counts, what was not leaves nothing.
#include "tests/unit/store/store_fixture.hpp"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;

/// The machine's, but for what is told to fail.
class FailingDisk : public Disk {
 public:
  bool names_fail = false;
  bool writes_fail = false;
  mutable std::size_t opened = 0, looked_at = 0;

  std::unique_ptr<DiskFile> create(const fs::path& file) override {
    return std::make_unique<FailingFile>(*this, under_->create(file));
  }
  std::unique_ptr<DiskFile> edit(const fs::path& file) override { return under_->edit(file); }
  [[nodiscard]] std::unique_ptr<DiskFile> open(const fs::path& file) const override {
    ++opened;
    return under_->open(file);
  }
  [[nodiscard]] std::uint64_t size_of(const fs::path& file) const override {
    ++looked_at;
    return under_->size_of(file);
  }
  std::unique_ptr<DiskFile> hold(const fs::path& file) override { return under_->hold(file); }
  bool make_folder(const fs::path& folder) override { return under_->make_folder(folder); }
  [[nodiscard]] std::vector<std::string> names(const fs::path& folder) const override {
    if (names_fail) throw Error(ErrorKind::failed, "no names", {.file = folder.string()});
    return under_->names(folder);
  }
  void remove(const fs::path& file) override { under_->remove(file); }
  void rename(const fs::path& from, const fs::path& to) override { under_->rename(from, to); }
  void sync_folder(const fs::path& folder) override { under_->sync_folder(folder); }

 private:
  class FailingFile : public DiskFile {
   public:
    FailingFile(const FailingDisk& disk, std::unique_ptr<DiskFile> under)
        : disk_(disk), under_(std::move(under)) {}
    [[nodiscard]] const fs::path& path() const override { return under_->path(); }
    [[nodiscard]] std::uint64_t size() const override { return under_->size(); }
    using DiskFile::write_at;
    void write_at(std::vector<iovec>& pieces, std::uint64_t offset) override {
      if (disk_.writes_fail) throw Error(ErrorKind::failed, "no space left");
      under_->write_at(pieces, offset);
    }
    void read_at(std::span<std::byte> bytes, std::uint64_t offset) const override {
      under_->read_at(bytes, offset);
    }
    void truncate(std::uint64_t size) override { under_->truncate(size); }
    void sync() override { under_->sync(); }
    void drop_cached(std::uint64_t from, std::uint64_t to) const noexcept override {
      under_->drop_cached(from, to);
    }

   private:
    const FailingDisk& disk_;
    std::unique_ptr<DiskFile> under_;
  };

  std::shared_ptr<Disk> under_ = system_disk();
};

class FailingDiskTest : public StoreTest {
 protected:
  std::shared_ptr<FailingDisk> disk = std::make_shared<FailingDisk>();
  std::unique_ptr<Store> store = open_on_disk();
  JobId job = store->put_job(job_record());

  [[nodiscard]] std::unique_ptr<Store> open_on_disk() const {
    return open({.durable = false, .segment_bytes = 1, .disk = disk});  // a segment a result
  }
  [[nodiscard]] Checkpoint write(std::uint32_t passes) const {
    const auto writer = store->begin_checkpoint(job, 1);
    writer->append(0, passes, bytes_of({1, 0, passes}, 1000));
    return writer->finish();
  }
  void append_passes(std::uint32_t passes) const {
    for (std::uint32_t pass = 0; pass < passes; ++pass) append(*store, job, {1, 0, pass});
  }
  /// What was left because the disk failed goes with the next start.
  void reopen() {
    disk->names_fail = false;
    store.reset();
    store = open_on_disk();
  }
};

TEST_F(FailingDiskTest, CheckpointThatIsCommittedCountsThoughNoSegmentCanBeRemoved) {
  append_passes(3);
  const Checkpoint made = write(2);
  disk->names_fail = true;
  EXPECT_NO_THROW(store->put_checkpoint(made));
  EXPECT_EQ(store->checkpoint_of(job, 1), made);
  expect_readable(*store, job, 1);
  EXPECT_EQ(segments().size(), 3U);
  reopen();
  EXPECT_EQ(store->checkpoint_of(job, 1), made);
  EXPECT_EQ(segments().size(), 1U);
}

TEST_F(FailingDiskTest, ExtensionThatIsCommittedCountsThoughNoSegmentCanBeRemoved) {
  append_passes(3);
  JobRecord more = job_record();
  more.id = job;
  more.extended_from = {20};
  more.spec.render.samples = 100;
  disk->names_fail = true;
  EXPECT_NO_THROW(store->extend_job(more, 2));
  EXPECT_EQ(store->list_jobs().at(0).spec, more.spec);
  expect_readable(*store, job, 2);
  reopen();
  EXPECT_EQ(segments().size(), 2U);
}

TEST_F(FailingDiskTest, EndThatIsCommittedCountsThoughNoSegmentCanBeRemoved) {
  append_passes(3);
  store->put_checkpoint(write(1));
  disk->names_fail = true;
  EXPECT_NO_THROW(store->forget_results(job));
  EXPECT_TRUE(results(*store, job).empty());
  EXPECT_NO_THROW(store->end_job(job));
  EXPECT_TRUE(store->jobs_with_checkpoints().empty());
  reopen();
  EXPECT_TRUE(segments().empty());
}

TEST_F(FailingDiskTest, StartLooksAtEachCheckpointOnceAndOpensNone) {
  constexpr std::size_t count = 50;
  for (std::int32_t frame = 1; frame <= static_cast<std::int32_t>(count); ++frame) {
    const auto writer = store->begin_checkpoint(job, frame);
    writer->append(0, 1, bytes_of({frame, 0, 0}, 10));
    store->put_checkpoint(writer->finish());
  }
  const std::uint64_t bytes = store->checkpoint_bytes();
  disk->opened = disk->looked_at = 0;
  reopen();
  EXPECT_EQ(disk->looked_at, count);
  EXPECT_LT(disk->opened, count / 2);
  EXPECT_EQ(store->checkpoint_bytes(), bytes);
}

TEST_F(FailingDiskTest, CheckpointWhoseFileCannotBeBegunLeavesNone) {
  disk->writes_fail = true;
  EXPECT_EQ(error_of([&] { static_cast<void>(store->begin_checkpoint(job, 1)); }).kind(),
            ErrorKind::failed);
  EXPECT_TRUE(fs::is_empty(folder_ / "checkpoints"));
}

}  // namespace
}  // namespace tessera::server
