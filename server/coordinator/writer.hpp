#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"
#include "server/coordinator/frame_film.hpp"
#include "server/schedule/scheduler.hpp"
#include "server/store/records.hpp"

/// The one thread that changes the store: it gathers what waits into groups and makes each durable
/// at once.
namespace tessera::server {

/// A result on its way: what was said of it, its bytes, and its pixels once they are decoded.
struct ArrivedResult {
  WorkerId worker = 0;
  ResultInfo info;
  std::string worker_name;
  Digest worker_build;
  std::shared_ptr<const std::vector<std::byte>> exr;
  std::shared_ptr<const DecodedTile> decoded;
  std::shared_ptr<void> budget;
  ResultPlace place;  ///< once it is durable
};

/// Makes a group durable; throws if it could not. Store::append_results stands behind it.
using AppendGroup = std::function<std::vector<ResultPlace>(std::vector<ArrivedResult>&)>;

struct WriterSettings {
  /// A group costs two syncs however large it is; at these sizes they are a small part of it.
  std::size_t group_results = 1024;
  std::size_t group_bytes = 16 * limits::MiB;
  Duration retry_first = std::chrono::milliseconds(100);  ///< after a failure; doubles up to
  Duration retry_most = std::chrono::seconds(5);
};

class Writer {
 public:
  /// Called on the writer's thread.
  struct Hooks {
    std::function<void(std::vector<ArrivedResult>)> committed;  ///< a group is durable
    /// The disk refuses a group, and why; empty once it takes it.
    std::function<void(const std::string& reason)> refused;
  };
  Writer(AppendGroup append, Hooks hooks, WriterSettings settings = {});
  /// stop().
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// A group that cannot be made durable (a full disk) is tried again until it can, or stop():
  /// no other group overtakes it, and nothing of it is said to be durable.
  void add(std::vector<ArrivedResult> results);
  /// Runs `work` between groups, after what was added before it; while the disk refuses a group,
  /// before it, so that people are answered. It must not throw.
  void run(std::function<void()> work);
  /// From here on a group that the disk refuses is dropped, unacknowledged: its workers keep it.
  void give_up();
  /// Finishes what is queued, as after give_up(), and ends the thread. Nothing may be added any
  /// more.
  void stop();

 private:
  using Item = std::variant<ArrivedResult, std::function<void()>>;

  void loop();
  std::vector<ArrivedResult> gather();
  void write(std::vector<ArrivedResult> group);
  /// Runs what is to be run meanwhile; false once it is to be given up.
  bool pause(Duration wait);

  AppendGroup append_;
  Hooks hooks_;
  WriterSettings settings_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  bool giving_up_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace tessera::server
