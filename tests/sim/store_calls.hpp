#pragma once
#include <fmt/format.h>

#include <memory>

#include "common/base/error.hpp"
#include "tests/sim/store_books.hpp"
#include "tests/sim/store_run.hpp"

namespace tessera::sim {

/// What is asked of the store, drawn, as a coordinator would; and what its books say of it then.
class StoreCalls {
 public:
  StoreCalls(Random& random, SimDisk& disk, bool trace);

  void use(server::Store* store) { store_ = store; }
  void one_change();
  /// False if it threw, or the process ended as it came back. Only where the disk failed it may
  /// throw.
  template <class What>
  bool call(const char* name, What what) {
    const std::uint64_t before = disk_.faults.failures();
    ++calls;
    if (trace_) fmt::print("{}\n", name);
    try {
      what();
      return disk_.commit_point();
    } catch (const Error& error) {
      if (trace_) fmt::print("  threw {}\n", error.what());
      require(disk_.faults.failures() > before || disk_.dead(),
              fmt::format("{} fails only where the disk does: {}", name, error.what()));
      return false;
    }
  }

  Books books;
  std::uint64_t calls = 0;

 private:
  JobId any_job();
  server::JobRecord record(JobId id);
  /// One commit of the job's: `what` is asked, and `change` is what it comes to.
  template <class What>
  void change_job(const char* name, JobId id, const What& what,
                  const Kept<JobTruth>::Change& change);

  void put_job();
  void update_job();
  void shorten_frame();
  void extend_job();
  void end_job();
  void forget_results();
  void forget_job();
  void skip_jobs();
  void add_failures();
  void append();
  void checkpoint();
  void write_frame();

  Random& random_;
  SimDisk& disk_;
  bool trace_;
  std::uint32_t tiles_;
  server::Store* store_ = nullptr;
  std::uint64_t number_ = 0;
};

}  // namespace tessera::sim
