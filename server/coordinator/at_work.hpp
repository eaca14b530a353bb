#pragma once
#include <memory>
#include <utility>

#include "server/coordinator/crew.hpp"
#include "server/coordinator/job_table.hpp"

/// What goes on with a job, as long as the object lives.
namespace tessera::server {

/// Counts a coroutine that ends or keeps something of the job.
class AtWork {
 public:
  /// `alive` expires as the coordinator is destroyed, without stop(), before its coroutines are:
  /// then job and signal are gone.
  AtWork(std::weak_ptr<const char> alive, Job& job, Signal& changed)
      : alive_(std::move(alive)), job_(job), changed_(changed) {
    ++job_.at_work;
  }
  ~AtWork() {
    if (!alive()) return;
    --job_.at_work;
    changed_.notify();
  }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
  [[nodiscard]] bool alive() const { return !alive_.expired(); }

 private:
  std::weak_ptr<const char> alive_;
  Job& job_;
  Signal& changed_;
};

/// A change of the job's record that somebody asked for; the next waits, so that what one takes
/// back is what stood before it.
class Changing {
 public:
  Changing(std::weak_ptr<const char> alive, Job& job, Signal& changed)
      : working_(std::move(alive), job, changed), job_(job) {
    job_.changing = true;
  }
  ~Changing() {
    if (working_.alive()) job_.changing = false;
  }
  Changing(const Changing&) = delete;
  Changing& operator=(const Changing&) = delete;

 private:
  AtWork working_;
  Job& job_;
};

}  // namespace tessera::server
