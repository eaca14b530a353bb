#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "common/base/digest.hpp"
#include "common/base/file.hpp"

namespace tessera::assets {

/// Which blobs of a folder are pinned, by all processes that share it. Each process has one file of
/// digests in DIR/pins, and holds its lock: a file whose lock is free is of a process that is gone.
/// DIR/pins.lock is held for each change and while a process evicts. Thread-safe.
class PinBoard {
 public:
  explicit PinBoard(std::filesystem::path folder);
  /// Takes this process's file away.
  ~PinBoard();
  PinBoard(const PinBoard&) = delete;
  PinBoard& operator=(const PinBoard&) = delete;

  std::uint64_t pin(std::vector<Digest> digests);
  void unpin(std::uint64_t number) noexcept;

  /// While it lives nothing is pinned or unpinned anywhere.
  class Held {
   public:
    [[nodiscard]] std::set<Digest> pinned() const;

   private:
    friend class PinBoard;
    Held(const PinBoard& board, std::unique_lock<std::mutex> threads, File processes)
        : board_(board), threads_(std::move(threads)), processes_(std::move(processes)) {}
    const PinBoard& board_;
    std::unique_lock<std::mutex> threads_;
    File processes_;
  };
  [[nodiscard]] Held hold();

 private:
  void publish();
  [[nodiscard]] std::set<Digest> own() const;

  std::filesystem::path folder_;
  std::filesystem::path own_path_;
  File own_file_;  ///< made by the first pin
  std::mutex mutex_;
  std::uint64_t last_ = 0;
  std::map<std::uint64_t, std::vector<Digest>> pins_;
};

}  // namespace tessera::assets
