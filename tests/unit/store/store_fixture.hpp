#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/random.hpp"
#include "server/store/store.hpp"

namespace tessera::server {

/// A data folder that is deleted at the end, and values to fill it with.
class StoreTest : public ::testing::Test {
 protected:
  StoreTest()
      : folder_(std::filesystem::temp_directory_path() / ("tessera-store-" + random_hex(8))) {}
  ~StoreTest() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::unique_ptr<Store> open(StoreSettings settings = {.durable = false}) const {
    return Store::open(folder_, settings);
  }

  static JobRecord job_record() {
    JobRecord record;
    record.spec.name = "cornell";
    record.spec.bundle = digest_of("a bundle");
    record.spec.render.width = 640;
    record.spec.render.height = 480;
    record.spec.priority = 3;
    record.priority = 3;
    record.created = 1'700'000'000'123;
    return record;
  }

  static std::string contents(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void overwrite(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  }

  /// Bytes that depend on the task, so that one record cannot pass for another.
  static std::vector<std::byte> bytes_of(const TaskId& task, std::size_t size) {
    std::vector<std::byte> bytes(size);
    std::uint64_t value = std::hash<TaskId>()(task) | 1;
    for (std::byte& byte : bytes) {
      value = value * 6364136223846793005ULL + 1442695040888963407ULL;
      byte = static_cast<std::byte>(value >> 56);
    }
    return bytes;
  }

  static ResultInfo info_of(JobId job, const TaskId& task) {
    ResultInfo info;
    info.job = job;
    info.plan = digest_of("a plan");
    info.task = task;
    info.lease = {7, 1000 + task.tile};
    info.identity = "0123456789abcdef0123456789abcdef";
    info.samples = 4096 * (task.pass + 1);
    info.rays = 123456789012;
    info.rejected = 2;
    info.seconds = 0.125;
    info.cpu_seconds = 0.25;
    return info;
  }

  static ResultPlace append(Store& store, JobId job, const TaskId& task, std::size_t size = 100) {
    const auto exr = bytes_of(task, size);
    const NewResult result{info_of(job, task), "worker 1", digest_of("a build"), exr};
    return store.append_results({&result, 1}).at(0);
  }

  static std::vector<IndexedResult> results(const Store& store, JobId job) {
    std::vector<IndexedResult> found;
    store.results_of(job, [&](const IndexedResult& result) { found.push_back(result); });
    return found;
  }

  /// Every indexed result of the job can be read and is what was put in.
  static void expect_readable(const Store& store, JobId job, std::size_t count) {
    const auto found = results(store, job);
    EXPECT_EQ(found.size(), count);
    for (const IndexedResult& result : found) {
      const StoredResult stored = store.read_result(result.place);
      EXPECT_EQ(stored.info, info_of(job, result.task));
      EXPECT_EQ(stored.exr, bytes_of(result.task, stored.exr.size()));
    }
  }

  [[nodiscard]] std::vector<std::filesystem::path> segments() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "journal"))
      files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
  }

  template <class Function>
  static Error error_of(Function function) {
    try {
      function();
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return {ErrorKind::failed, ""};
  }

  std::filesystem::path folder_;
};

}  // namespace tessera::server
