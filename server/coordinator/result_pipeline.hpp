#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/coordinator/crew.hpp"
#include "server/coordinator/writer.hpp"

/// From bytes that arrived to a durable result: decoded and checked on the pool, journaled by the
/// writer. Threads are changed once per batch, not once per result.
namespace tessera::server {

class ResultPipeline {
 public:
  struct Hooks {
    /// On the I/O thread, in the order in which they were journaled.
    std::function<void(std::vector<ArrivedResult>)> durable;
    /// On the I/O thread: the tile is not what its task asked for, and why.
    std::function<void(const ArrivedResult&, const std::string& reason)> invalid;
    /// On the I/O thread: the disk refuses results, and why; empty once it takes them again.
    std::function<void(const std::string& reason)> refused;
  };

  ResultPipeline(boost::asio::any_io_executor io, boost::asio::thread_pool& pool, int lanes,
                 Crew& crew, AppendGroup append, Hooks hooks);

  /// A result that the scheduler takes. Those that arrive in one turn of the I/O thread go on
  /// together.
  void arrived(ArrivedResult result, const image::TileExpectation& expected);
  [[nodiscard]] Writer& writer() { return writer_; }

 private:
  using Job = std::pair<ArrivedResult, image::TileExpectation>;
  void flush();
  void decode(std::vector<Job> jobs);

  boost::asio::any_io_executor io_;
  boost::asio::thread_pool& pool_;
  std::size_t lanes_;
  Crew& crew_;
  Hooks hooks_;
  std::vector<Job> gathered_;
  Writer writer_;
};

}  // namespace tessera::server
